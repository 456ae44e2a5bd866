// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// Depth maps as training and measuring programs read them: one channel, rows from the top, 0 where there is
// no depth. Formats and what reads them: docs/depth.md.

namespace alidade::image {

enum class DepthFormat {
  exr,    ///< channels Y (for OpenCV) and Z, both the depth, float
  png16,  ///< whole numbers from 1 to 65535
  npy,    ///< NumPy's format 1.0: float32, (height, width), C order, little endian
  tiff,   ///< float
  colmap  ///< COLMAP's "WIDTH&HEIGHT&1&" and float32, little endian
};

/// A format, the word for it on command lines, and the extensions its files have.
struct NamedDepthFormat {
  std::string_view name;
  DepthFormat format;
  std::array<std::string_view, 2> extensions;  ///< the second may be empty
};

/// Every format, in the order of the enum.
inline constexpr std::array<NamedDepthFormat, 5> k_depth_formats = {
    {{"exr", DepthFormat::exr, {".exr", ""}},
     {"png16", DepthFormat::png16, {".png", ""}},
     {"npy", DepthFormat::npy, {".npy", ""}},
     {"tiff", DepthFormat::tiff, {".tif", ".tiff"}},
     {"colmap", DepthFormat::colmap, {".bin", ""}}}};

/// The format by the extension of a name, in upper or lower case. Errors: none of the extensions.
DepthFormat depth_format(const std::filesystem::path& file);

inline constexpr double k_largest_depth_code = 65535.0;  ///< of png16

/// Units per metre by default: 1000 (millimetres) for png16, 1 (metres) for all others.
double default_depth_scale(DepthFormat format);

/// Pixels of a film that met a surface and whose depth a map cannot hold.
struct DepthLoss {
  std::uint64_t too_far = 0;  ///< above 65535 units, of png16
  std::uint64_t behind = 0;   ///< 90 degrees or more off the optical axis: no depth along it
  double farthest = 0.0;      ///< metres, of those too far

  DepthLoss& operator+=(const DepthLoss& other);
};

/// A film's depths in units of 1 / scale metres; infinity and lost depths become 0. png16: rounded to the
/// nearest whole number, to 1 below that, so that 0 always means no depth. With scale 1 the other formats
/// keep every bit.
std::vector<float> depth_values(std::span<const float> depths, DepthFormat format, double scale,
                                DepthLoss& loss);

/// The bytes in front of the values in the formats npy and colmap.
std::string depth_map_head(DepthFormat format, int width, int height);

}  // namespace alidade::image
