// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "cloud/e57/e57_document.h"
#include "cloud/e57/e57_roles.h"
#include "cloud/point_table.h"

namespace alidade {

/// How the values of one scan become 0 .. 65535.
struct E57Scaling {
  std::array<ValueScaling, 3> colors;  ///< red, green, blue
  ValueScaling intensities;
};

/// What the first pass met in one scan, without what is flagged as invalid.
struct E57Values {
  ValueRange colors, intensities;
};

/// Decides for every scan. Each has a scale of its own:
/// - limits of the scan (colorLimits, intensityLimits), where the largest is above the smallest;
/// - otherwise of intensities the range that the field itself states; of colours as integers 0 to the next of
///   255 and 65535, or to the field's maximum if that is one less than a power of two above 255, because
///   fields state what occurs as often as what can occur; of colours as floats that range where it is 0 to 1,
///   255 or 65535;
/// - otherwise what color_scaling() and intensity_scaling() say of all such scans together.
/// Where values go beyond the range, it is widened to the next of 255 and 65535 that holds them (colours) or
/// to the values (intensities); but colours between -1 and 2 are held at the ends of 0 to 1, because that
/// much is what filters leave. What was assumed, widened or held is added to `oddities`.
std::vector<E57Scaling> e57_scalings(const std::vector<E57Scan>& scans, const std::vector<E57Roles>& roles,
                                     const std::vector<E57Values>& values, AttributeSet wanted,
                                     E57Oddities& oddities);

}  // namespace alidade
