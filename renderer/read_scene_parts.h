// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "base/json.h"
#include "renderer/scene.h"

// How the scene reader is split over its files. Ranges are those of scenes/schema, which the tests compare.

namespace alidade {

/// Coordinates and lengths: beyond any place on or near Earth, and squares stay far from the limits of
/// double.
inline constexpr double k_largest_length = 1e12;
inline constexpr NumberRange k_coordinate{-k_largest_length, k_largest_length};
inline constexpr NumberRange k_length{0.0, k_largest_length, true};
/// Radiance and irradiance per channel.
inline constexpr NumberRange k_light{0.0, 1e9};

/// "version" must be 1.
void read_version(const JsonNode& version);

/// A camera; its "version" may be left out when it stands inside a scene.
Camera read_camera_node(const JsonNode& node);

/// Which of k_lens_names a camera's "model" is.
std::size_t model_of(const JsonNode& camera);
/// Whether cameras of that model have a "distortion".
bool is_distorting(std::size_t model);
/// "intrinsics" of a camera of that model: sets its focal lengths, principal point and, without distortion,
/// lens. Needs its size.
void read_intrinsics(const JsonNode& node, std::size_t model, Camera& camera);
/// "distortion" of a camera of a distorting model.
Lens read_distortion(const JsonNode& node, std::size_t model);

/// A material. `of_cloud`: points have a colour of their own, so that the albedo may be left out.
Material read_material(const JsonNode& node, bool of_cloud);

/// "color" of a cloud.
PointColoring read_coloring(const JsonNode& node);

/// A sky.
Sky read_sky(const JsonNode& node, const std::filesystem::path& scene_file);

/// Sets `sun` or `sun_by_time`.
void read_sun(const JsonNode& node, Scene& scene);

/// The name in the node, taken relative to the scene file.
std::filesystem::path path_beside(const std::filesystem::path& scene_file, const JsonNode& node);

/// Three values, each in `range`.
Rgb read_rgb(const JsonNode& node, const NumberRange& range);

/// What scene files and our camera files may have in bytes.
inline constexpr std::uintmax_t k_largest_scene_file = 4u << 20;

/// A text file of at most so many bytes. Errors: missing, not a regular file, too large, unreadable.
std::string read_text_file(const std::filesystem::path& file, std::uintmax_t largest = k_largest_scene_file);

}  // namespace alidade
