// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

// Files with a row of named values for each of many things, which may lie somewhere.

namespace alidade::visibility {

enum class RowForm { csv, json, geojson };

/// By the extension: .csv, .json or .geojson; empty for any other.
std::optional<RowForm> row_form(const std::filesystem::path& file);

/// What is said of a whole file, beside its rows. CSV cannot hold it.
struct RowFileHead {
  std::string command{};                   ///< command line, or empty
  std::vector<std::string> cloud_files{};  ///< what the points come from
};

/// Turns positions into longitude and latitude (degrees, WGS 84) and leaves z; empty if it cannot. A function,
/// so that programs without GDAL at hand can do without (geo/earth.h).
using ToLonLat = std::function<std::optional<std::vector<glm::dvec3>>(std::span<const glm::dvec3>)>;

}  // namespace alidade::visibility
