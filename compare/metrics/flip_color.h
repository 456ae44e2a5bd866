// SPDX-License-Identifier: MIT
#pragma once

namespace alidade {

/// The colour spaces of FLIP. Source: as FlipFilters; matrices of sRGB's primaries and D65 as the tool has
/// them. CIE XYZ is told relative to the white point (1, 1, 1), and the opponent space YCxCz without its
/// constant and factors (y = (Y + 16) / 116, x - y = Cx / 500, y - z = Cz / 200), which filters of sum 1 do
/// not see.
struct FlipColor {
  float xyz_from_rgb[3][3];  ///< rows x y z: each adds up to 1, so that grey stays grey
  float rgb_from_xyz[3][3];
  float largest_difference;  ///< between green and blue, to the power 0.7
};

/// A colour in CIE L*a*b* after the Hunt effect: a and b times 0.01 L.
struct HuntColor {
  double lightness, a, b;
};
HuntColor hunt_color(double x, double y, double z);

/// HyAB distance.
double color_distance(const HuntColor& one, const HuntColor& other);

const FlipColor& flip_color();

}  // namespace alidade
