// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <utility>
#include <vector>

#include "camera/camera.h"
#include "cloud/crs.h"
#include "image/image_file.h"
#include "renderer/scene.h"

namespace alidade::renderer {

/// Where an image comes from.
struct ImageMetadata {
  camera::Camera camera;
  RenderSettings render;
  std::string command;  ///< command line, or empty
  std::vector<std::string> cloud_files;
  glm::dvec3 cloud_offset{0.0};
  Crs crs;
  double radius = 0.0;                                       ///< metres, 0 without a cloud
  std::vector<std::pair<std::string, std::string>> further;  ///< any other key and text
};

/// The metadata as texts, in the order of docs/scene_format.md; what is empty is left out. Numbers have 17
/// significant digits.
std::vector<std::pair<std::string, std::string>> metadata_texts(const ImageMetadata& metadata);

/// Positions in an image are float, too coarse for coordinates like 5325000. They are therefore stored
/// relative to this point: the camera's position rounded to 10 km along each axis. It is 0 0 0 for sites
/// around the origin, and the same for cameras near each other.
glm::dvec3 position_offset(const camera::Camera& camera);

/// What an image file of this name holds besides its pixels; the ground transform only in a GeoTIFF. Errors
/// then: those of ground_transform().
image::ImageFacts image_facts(const ImageMetadata& metadata, const image::OutputSettings& output);

/// Writes the film with its image_facts(). Errors: theirs as well.
inline void write_image(const image::Film& film, const image::OutputSettings& output,
                        const ImageMetadata& metadata, bool overwrite) {
  image::write_image(film, output, image_facts(metadata, output), overwrite);
}

}  // namespace alidade::renderer
