// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "base/json.h"
#include "camera/camera.h"

namespace alidade::camera {

/// Range of the coefficients of lenses, in files of any program.
inline constexpr NumberRange k_coefficient{-1e6, 1e6};

/// The value of a key. Errors: the key is missing.
JsonNode required(const JsonNode& node, std::string_view key);

/// A transform of positions: a rotation, which includes a scale in some files, and a translation.
struct Transform {
  glm::dmat3 rotation{1.0};
  glm::dvec3 translation{0.0};
};

/// A transform from the rows of its matrix, of four numbers each; a fourth row is not examined.
Transform read_transform(const std::vector<JsonNode>& rows);

/// The camera as a camera file on one line; parse_camera() returns an identical camera, bit for bit.
std::string camera_json(const Camera& camera);

/// Reads an Alidade camera file (scenes/schema/camera.schema.json). Errors: Error with file, line:column,
/// JSON pointer, what was expected and found; unknown keys name the nearest known one.
Camera read_camera(const std::filesystem::path& file);

/// Reads the text of such a file; `name` is used in messages.
Camera parse_camera(std::string_view text, const std::filesystem::path& name);

/// Reads a camera inside a scene or another file, where "version" is optional.
Camera read_camera_node(const JsonNode& node);

}  // namespace alidade::camera
