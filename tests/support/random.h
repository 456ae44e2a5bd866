// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <random>
#include <string_view>

namespace alidade::test {

/// Random numbers of a test: the same on every run and machine, seeded by a name (usually the test's own).
class Random {
 public:
  explicit Random(std::string_view name) {
    std::uint64_t hash = 14695981039346656037u;
    for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
    engine_.seed(hash);
  }

  /// Seeded by the running test.
  Random() : Random(::testing::UnitTest::GetInstance()->current_test_info()->name()) {}

  std::uint64_t bits() { return engine_(); }
  /// In [0, 1).
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// In [0, count).
  std::uint64_t below(std::uint64_t count) { return engine_() % count; }
  glm::dvec3 in_cube() { return {between(-1, 1), between(-1, 1), between(-1, 1)}; }
  /// Not normalised.
  glm::dvec3 direction() {
    for (;;) {
      const glm::dvec3 v = in_cube();
      const double square = v.x * v.x + v.y * v.y + v.z * v.z;
      if (square > 0.01 && square <= 1.0) return v;
    }
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace alidade::test
