// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cloud/crs.h"
#include "image/depth_map.h"
#include "image/film.h"
#include "image/output_settings.h"

namespace alidade::image {

class Canvas;

/// Metadata of an image file.
struct ImageFacts {
  std::vector<std::pair<std::string, std::string>> texts;  ///< key and text
  glm::dvec3 position_offset{0.0};                         ///< positions are stored relative to it
  std::optional<std::array<double, 6>> ground{};           ///< GeoTIFF only: GroundImage::transform
  Crs crs;                                                 ///< GeoTIFF only
};

/// Writes the film by the extension of `output.file`: .exr with the requested layers, .png (8 bit) or .jpg
/// with exposure and the sRGB curve, .tif as GeoTIFF: like PNG with alpha, and georeferenced by
/// `facts.ground`, which it requires. The film must hold colour and alpha, for EXR the layers. The file is
/// written completely or not at all. Channel names and metadata keys: docs/scene_format.md.
/// Errors: unknown extension, a layer that the film lacks, existing file without `overwrite`, a full disk and
/// other write failures, anything OpenImageIO reports. Memory: the encoded image.
void write_image(const Film& film, const OutputSettings& output, const ImageFacts& facts, bool overwrite);

/// "OpenImageIO 2.4.7": the library that reads and writes images.
std::string library_version();

/// Loads the library, for callers that work for long before they write an image. Errors: it is missing.
void load_library();

/// Writes a canvas as PNG. The file is written completely or not at all. Errors: a name that does not end in
/// .png; an existing file without `overwrite`; a full disk and other write failures.
void write_png(const Canvas& canvas, const std::filesystem::path& file, bool overwrite);

/// Writes the values of depth_values(), width times height of them, in a format. `texts`: keys and texts,
/// kept by EXR, PNG and TIFF. The file is written completely or not at all. Errors: an existing file without
/// `overwrite`; a full disk and other write failures, anything OpenImageIO reports. Memory: the encoded map.
void write_depth_map(std::span<const float> values, int width, int height, DepthFormat format,
                     const std::vector<std::pair<std::string, std::string>>& texts,
                     const std::filesystem::path& file, bool overwrite);

/// Writes which pixels met a surface, those with a finite depth, as PNG of one channel: 255, others 0.
/// Errors: as write_depth_map().
void write_depth_mask(std::span<const float> depths, int width, int height, const std::filesystem::path& file,
                      bool overwrite);

}  // namespace alidade::image
