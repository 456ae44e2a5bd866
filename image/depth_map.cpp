// SPDX-License-Identifier: MIT
#include "image/depth_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "base/error.h"
#include "base/words.h"

namespace alidade::image {
namespace {

/// Magic, version 1.0, length and text, padded with blanks to a multiple of 64 bytes as NumPy requires.
std::string npy_head(int width, int height) {
  constexpr std::size_t k_before_text = 10, k_alignment = 64;
  std::string text = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::to_string(height) + ", " +
                     std::to_string(width) + "), }";
  const std::size_t used = k_before_text + text.size() + 1;
  text.append((k_alignment - used % k_alignment) % k_alignment, ' ');
  text += '\n';
  std::string head("\x93NUMPY\x01\x00", 8);
  head += static_cast<char>(text.size() & 0xff);
  head += static_cast<char>(text.size() >> 8);
  return head + text;
}

}  // namespace

DepthFormat depth_format(const std::filesystem::path& file) {
  const std::string extension = file_extension(file);
  for (const NamedDepthFormat& known : k_depth_formats) {
    if (!extension.empty() && std::ranges::find(known.extensions, extension) != known.extensions.end())
      return known.format;
  }
  throw file_error(file, "unknown format of depth maps",
                   "the extension .png (16 bit), .exr, .npy, .tif or .bin (COLMAP)",
                   extension.empty() ? "no extension" : extension);
}

double default_depth_scale(DepthFormat format) {
  return format == DepthFormat::png16 ? 1000.0 : 1.0;
}

DepthLoss& DepthLoss::operator+=(const DepthLoss& other) {
  too_far += other.too_far;
  behind += other.behind;
  farthest = std::max(farthest, other.farthest);
  return *this;
}

std::vector<float> depth_values(std::span<const float> depths, DepthFormat format, double scale,
                                DepthLoss& loss) {
  std::vector<float> values(depths.size(), 0.0f);
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const double depth = depths[i];
    if (!std::isfinite(depth)) continue;
    if (depth <= 0.0) {
      ++loss.behind;
    } else if (format != DepthFormat::png16) {
      values[i] = static_cast<float>(depth * scale);
    } else if (const double code = std::max(1.0, std::round(depth * scale)); code <= k_largest_depth_code) {
      values[i] = static_cast<float>(code);
    } else {
      ++loss.too_far;
      loss.farthest = std::max(loss.farthest, depth);
    }
  }
  return values;
}

std::string depth_map_head(DepthFormat format, int width, int height) {
  assert(format == DepthFormat::npy || format == DepthFormat::colmap);
  if (format == DepthFormat::npy) return npy_head(width, height);
  return std::to_string(width) + "&" + std::to_string(height) + "&1&";
}

}  // namespace alidade::image
