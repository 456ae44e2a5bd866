// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "image/color_key.h"
#include "image/point_values.h"

namespace alidade::image {

/// One of the few values of a column, and how it is shown.
struct ValueCategory {
  double value = 0.0;
  Swatch swatch{};
};

/// More different values than this are shown along a scale.
inline constexpr std::size_t k_most_categories = 24;

/// The different values of a column of numbers, in ascending order, with a colour each; empty if there are
/// more than k_most_categories, or a value is not a whole number from 0 to 2^53. Numbers that count up from 0
/// or 1 have colours along `map`, others (flight lines, objects) and masks those of distinct_color(), a
/// mask without bits grey. The labels of masks list the bits that are set, the lowest being 1. NaN values are
/// ignored. Cost: one pass, in parallel.
std::vector<ValueCategory> categories_of(const PointValues& values, ColorMap map, bool are_masks);

/// How many bits are set in each whole number; of values that are whole numbers from 0 to 2^64.
PointValues bit_counts(const PointValues& masks);

}  // namespace alidade::image
