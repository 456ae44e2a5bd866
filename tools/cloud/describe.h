// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cloud/point_cloud.h"
#include "octree/index_file/index_file.h"

namespace alidade::tools {

/// How the box in a file's header differs from that of its points, in words for people: how far it lies
/// beyond them ("wider"), how far they lie beyond it ("leaves out"). Empty if no face is off by more than a
/// hundredth of a step of the lattice, or if there are no points. Half a step is common and told, too: who
/// crops by the box loses points.
std::optional<std::string> header_box_text(const Bounds& stated, const Bounds& points,
                                           const Lattice& lattice);

/// Box of the rows [begin, end) of a cloud, of those of them that it has. Cost: linear.
Bounds bounds_of_rows(const PointCloud& cloud, std::size_t begin, std::size_t end);

/// What `alidade info` tells about the octree of a COPC file: levels, nodes and spacing, or what is wrong
/// with it.
std::string copc_text(const std::filesystem::path& file);

using Json = nlohmann::ordered_json;

/// What `alidade info --json` tells about an index file beside what its points tell.
Json index_json(const IndexFile& index, bool verified);

/// The same as lines for people.
std::vector<std::string> index_lines(const IndexFile& index, bool verified);

}  // namespace alidade::tools
