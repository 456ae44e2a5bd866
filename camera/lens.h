// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>
#include <variant>

// Models of lenses, as plain numbers. A lens turns a direction in the camera's axes, (X, Y, Z) = (right,
// down, forward), into a position on a film one focal length behind it; the camera's fx, fy, cx, cy turn that
// position into pixels. u = X / Z, v = Y / Z; theta = angle off the axis. Formulas: docs/cameras.md.

namespace alidade::camera {

/// From the position (x, y) on the ideal film to (x', y') on the real one. With q = x^2 + y^2:
///   (c, d) = (x, y) (1 + sum radial[i] q^(i+1)) / (1 + sum denominator[i] q^(i+1))
///   x' = c + 2 p1 a b + p2 (s + 2 a^2) + prism[0] s + prism[1] s^2
///   y' = d + 2 p2 a b + p1 (s + 2 b^2) + prism[2] s + prism[3] s^2,  s = a^2 + b^2,
/// where (a, b) is (x, y), or (c, d) if `after_radial`.
struct Distortion {
  std::array<double, 6> radial{};
  std::array<double, 3> denominator{};
  double p1 = 0.0, p2 = 0.0;
  std::array<double, 4> prism{};
  bool after_radial = false;

  bool operator==(const Distortion&) const = default;
};

/// Straight lines stay straight: film (u, v).
struct PinholeLens {};

/// Film (u, v), distorted. Brown 1966 and OpenCV: radial = k1 k2 k3 (and r^8), denominator = k4 k5 k6.
struct BrownLens {
  Distortion distortion;
};

/// Film theta (X, Y) / sqrt(X^2 + Y^2), distorted: equidistant, as OpenCV's fisheye. Sees up to theta = pi.
struct FisheyeLens {
  Distortion distortion;
};

/// Film (u, v) atan(2 r tan(omega / 2)) / (r omega), r^2 = u^2 + v^2. Devernay and Faugeras 2001.
struct FieldOfViewLens {
  double omega = 0.0;  ///< radians, (-pi, pi); 0 = pinhole
};

/// Film p with (u, v) = p / (1 + k |p|^2). Fitzgibbon 2001.
struct DivisionLens {
  double k = 0.0;
};

/// Film (X, Y) / (alpha sqrt(beta (X^2 + Y^2) + Z^2) + (1 - alpha) Z). Khomutenko, Garcia, Martinet 2016.
struct UnifiedLens {
  double alpha = 0.0;  ///< [0, 1]
  double beta = 1.0;   ///< above 0
};

/// A mixture of pinhole and fisheye, as OpenSfM's "dual": film = transition (u, v) + (1 - transition) theta
/// (X, Y) / sqrt(X^2 + Y^2), distorted.
struct DualLens {
  double transition = 1.0;  ///< [0, 1]
  Distortion distortion;
};

/// Parallel rays: film (X, Y) in metres, so that fx and fy are pixels per metre. The rays start in the
/// camera's plane.
struct OrthographicLens {};

/// All directions: film (longitude, -latitude) in radians, longitude 0 ahead and rising to the right,
/// latitude rising upwards.
struct EquirectangularLens {};

using Lens = std::variant<PinholeLens, BrownLens, FisheyeLens, FieldOfViewLens, DivisionLens, UnifiedLens,
                          DualLens, OrthographicLens, EquirectangularLens>;

/// The name of each lens in camera files, in the order of the variant.
inline constexpr std::array<std::string_view, std::variant_size_v<Lens>> k_lens_names = {
    "pinhole", "brown", "fisheye", "fov", "division", "unified", "dual", "orthographic", "equirectangular"};

}  // namespace alidade::camera
