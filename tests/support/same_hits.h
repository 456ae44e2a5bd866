// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <optional>
#include <ostream>
#include <span>
#include <vector>

#include "octree/query.h"

// Bits, not values: a difference must show as the numbers that differ.

namespace alidade {

inline void PrintTo(const Hit& hit, std::ostream* out) {
  *out << std::hexfloat << "point " << hit.point_id << " t " << hit.t << " distance " << hit.distance
       << " entry " << hit.entry;
}

inline void PrintTo(const PointHit& hit, std::ostream* out) {
  *out << std::hexfloat << "point " << hit.point_id << " distance " << hit.distance;
}

inline void PrintTo(const PathHit& hit, std::ostream* out) {
  *out << std::hexfloat << "point " << hit.point_id << " segment " << hit.segment << " t " << hit.t
       << " distance " << hit.distance;
}

namespace test {

inline bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

/// Whether two answers are the same; -0.0 and 0.0 differ.
template <class Answer>
bool same_hit(const Answer& a, const Answer& b) {
  bool same = a == b && same_bits(a.distance, b.distance);
  if constexpr (requires { a.t; }) same = same && same_bits(a.t, b.t);
  if constexpr (requires { a.entry; }) same = same && same_bits(a.entry, b.entry);
  return same;
}

/// The one comparison of answers with brute force: distances rank by rank first, then which points are
/// missing and which too many, then every bit in its order.
template <class Answer>
::testing::AssertionResult same_hits(std::span<const Answer> found, std::span<const Answer> expected) {
  const auto fail = [&] {
    return ::testing::AssertionFailure() << found.size() << " found, " << expected.size() << " expected; ";
  };
  for (std::size_t i = 0; i < std::min(found.size(), expected.size()); ++i) {
    if (same_bits(found[i].distance, expected[i].distance)) continue;
    return fail() << "distances differ first at rank " << i << ": " << ::testing::PrintToString(found[i])
                  << " instead of " << ::testing::PrintToString(expected[i]);
  }
  const auto ids = [](std::span<const Answer> answers) {
    std::vector<std::uint64_t> result;
    for (const Answer& answer : answers) result.push_back(answer.point_id);
    std::ranges::sort(result);
    return result;
  };
  const std::vector<std::uint64_t> found_ids = ids(found), expected_ids = ids(expected);
  std::vector<std::uint64_t> missing, extra;
  std::ranges::set_difference(expected_ids, found_ids, std::back_inserter(missing));
  std::ranges::set_difference(found_ids, expected_ids, std::back_inserter(extra));
  if (!missing.empty() || !extra.empty()) {
    return fail() << "missing ids " << ::testing::PrintToString(missing) << ", extra ids "
                  << ::testing::PrintToString(extra);
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (same_hit(found[i], expected[i])) continue;
    return fail() << "rank " << i << ": " << ::testing::PrintToString(found[i]) << " instead of "
                  << ::testing::PrintToString(expected[i]);
  }
  return ::testing::AssertionSuccess();
}

template <class Answer>
::testing::AssertionResult same_hits(const std::vector<Answer>& found, const std::vector<Answer>& expected) {
  return same_hits(std::span<const Answer>(found), std::span<const Answer>(expected));
}

template <class Answer>
::testing::AssertionResult same_hits(const std::optional<Answer>& found,
                                     const std::optional<Answer>& expected) {
  return same_hits(found ? std::vector{*found} : std::vector<Answer>(),
                   expected ? std::vector{*expected} : std::vector<Answer>());
}

}  // namespace test
}  // namespace alidade
