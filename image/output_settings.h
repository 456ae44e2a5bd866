// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "base/color.h"

namespace alidade::image {

/// One group of image channels.
enum class Layer {
  color,
  depth,
  distance,
  normal,
  position,
  albedo,
  id,
  variance,
  depth_sigma,
  coverage,
  support
};

/// A layer and the word for it in scene files and on command lines.
struct NamedLayer {
  std::string_view name;
  Layer layer;
};

/// Every layer, in the order of the enum.
inline constexpr std::array<NamedLayer, 11> k_layers = {{{"color", Layer::color},
                                                         {"depth", Layer::depth},
                                                         {"distance", Layer::distance},
                                                         {"normal", Layer::normal},
                                                         {"position", Layer::position},
                                                         {"albedo", Layer::albedo},
                                                         {"id", Layer::id},
                                                         {"variance", Layer::variance},
                                                         {"depth.sigma", Layer::depth_sigma},
                                                         {"coverage", Layer::coverage},
                                                         {"support", Layer::support}}};

struct OutputSettings {
  std::filesystem::path file;               ///< .exr, .png, .jpg, .tif; may be empty in a scene file
  std::vector<Layer> layers{Layer::color};  ///< EXR only
  double exposure = 0.0;                    ///< stops: PNG, JPEG and GeoTIFF show color * 2^exposure, sRGB
  /// The sky that the camera sees gives no light: PNG gets alpha, colours of EXR are premultiplied with
  /// theirs.
  bool transparent = false;
  /// PNG and JPEG: colour behind the surfaces instead of the sky, display-referred, whatever the exposure.
  std::optional<Rgb> background{};
  bool half = true;  ///< EXR: colour, normal and albedo as half; all others are always float or uint
};

enum class ImageFormat { exr, png, jpeg, geotiff };

/// The format by the extension of a name: .exr, .png, .jpg, .jpeg, .tif or .tiff, in upper or lower case;
/// empty for any other.
std::optional<ImageFormat> image_format(const std::filesystem::path& file);

/// Lets a long render fail before it starts. Errors: a name without any of these extensions.
void check_image_name(const std::filesystem::path& file);

}  // namespace alidade::image
