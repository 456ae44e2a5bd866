// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cloud/crs.h"
#include "image/canvas.h"
#include "image/film.h"
#include "renderer/scene.h"

namespace alidade {

/// What an image file says about where it comes from.
struct ImageMetadata {
  Camera camera;
  RenderSettings render;
  std::string command;  ///< command line, or empty
  std::vector<std::string> cloud_files;
  glm::dvec3 cloud_offset{0.0};
  Crs crs;
  double radius = 0.0;                                       ///< metres, 0 without a cloud
  std::vector<std::pair<std::string, std::string>> further;  ///< any other key and text
};

enum class ImageFormat { exr, png, jpeg, geotiff };

/// What the name of a picture asks for: .exr, .png, .jpg, .jpeg, .tif or .tiff, in upper or lower case; empty
/// for any other.
std::optional<ImageFormat> image_format(const std::filesystem::path& file);

/// Lets a long render fail before it starts. Errors: the name ends in none of them.
void check_image_name(const std::filesystem::path& file);

/// Writes the film by the extension of `output.file`: .exr with the layers asked for, .png (8 bit) or .jpg
/// with exposure and the sRGB curve, .tif as GeoTIFF, like PNG with alpha and with its place on the ground
/// (cameras with parallel rays from straight above only). The film must hold colour and alpha, for EXR the
/// layers. The file appears whole or not at all. Channel names and metadata keys: docs/scene_format.md.
/// Errors: unknown extension, a layer that the film lacks, existing file without `overwrite`, a full disk and
/// other write failures, anything OpenImageIO reports. Memory: the encoded picture.
void write_image(const Film& film, const OutputSettings& output, const ImageMetadata& metadata,
                 bool overwrite);

/// Writes a canvas as PNG. The file appears whole or not at all. Errors: a name that does not end in .png; an
/// existing file without `overwrite`; a full disk and other write failures.
void write_png(const Canvas& canvas, const std::filesystem::path& file, bool overwrite);

}  // namespace alidade
