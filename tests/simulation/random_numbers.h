// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <random>
#include <string>

namespace alidade::test {

/// Numbers that depend on the running test's name and on nothing else.
class RandomNumbers {
 public:
  RandomNumbers() {
    const std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::uint64_t seed = 1469598103934665603u;  // FNV-1a
    for (const char letter : name) seed = (seed ^ static_cast<unsigned char>(letter)) * 1099511628211u;
    engine_.seed(seed);
    ::testing::Test::RecordProperty("seed", std::to_string(seed));
  }

  double between(double low, double high) { return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53; }
  std::uint64_t below(std::uint64_t count) { return engine_() % count; }
  glm::dvec3 in_box(const glm::dvec3& half) {
    const double x = between(-half.x, half.x), y = between(-half.y, half.y), z = between(-half.z, half.z);
    return {x, y, z};
  }
  glm::dvec3 direction() {
    while (true) {
      const glm::dvec3 place = in_box(glm::dvec3(1.0));
      const double length = glm::length(place);
      if (length <= 1.0 && length > 0.01) return place / length;
    }
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace alidade::test
