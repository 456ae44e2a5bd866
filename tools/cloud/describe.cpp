// SPDX-License-Identifier: MIT
#include "tools/cloud/describe.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "cloud/copc/copc_file.h"

namespace alidade::tools {

std::optional<std::string> header_box_text(const Bounds& stated, const Bounds& points,
                                           const Lattice& lattice) {
  if (points.empty()) return std::nullopt;
  double wider = 0.0, left_out = 0.0, finest = lattice.scale.x;
  for (int axis = 0; axis < 3; ++axis) {
    finest = std::min(finest, lattice.scale[axis]);
    for (const double beyond : {points.min[axis] - stated.min[axis], stated.max[axis] - points.max[axis]}) {
      if (std::fabs(beyond) <= 0.01 * lattice.scale[axis]) continue;
      wider = std::max(wider, beyond);
      left_out = std::max(left_out, -beyond);
    }
  }
  if (wider == 0.0 && left_out == 0.0) return std::nullopt;
  const int decimals = static_cast<int>(std::clamp(std::ceil(-std::log10(finest) - 1e-9) + 1.0, 0.0, 17.0));
  std::string text;
  if (wider > 0.0) text = fmt::format("up to {:.{}f} wider than the points", wider, decimals);
  if (left_out > 0.0)
    text += fmt::format("{}leaves out points by up to {:.{}f}", text.empty() ? "" : "; ", left_out, decimals);
  return text;
}

Bounds bounds_of_rows(const PointCloud& cloud, std::size_t begin, std::size_t end) {
  Bounds bounds;
  for (std::size_t row = begin; row < std::min(end, cloud.size()); ++row) bounds.grow(cloud.world(row));
  return bounds;
}

std::string copc_text(const std::filesystem::path& file) {
  try {
    const CopcFile copc{InputFile(file)};
    const auto& nodes = copc.hierarchy().nodes;
    const auto chunks =
        std::ranges::count_if(nodes, [](const CopcNode& node) { return node.chunk.point_count > 0; });
    return fmt::format("octree of {} levels, {} nodes with points, spacing {} in the root",
                       copc.hierarchy().levels(), chunks, copc.info().spacing);
  } catch (const Error& error) {
    return fmt::format("octree that cannot be used: {}", error.parts().problem);
  }
}

namespace {

const char* organisation_name(Organisation organisation) {
  switch (organisation) {
    case Organisation::fixed:
      return "fixed";
    case Organisation::layered:
      return "layered";
    case Organisation::adaptive:
      break;
  }
  return "adaptive";
}

/// Bytes of a file, or of its octree alone, for each of its points.
double bytes_per_point(const IndexFile& index, std::uint64_t bytes) {
  const std::uint32_t points = index.header().tree.point_count;
  return points > 0 ? static_cast<double>(bytes) / points : 0.0;
}

std::uint64_t octree_bytes(const IndexFile& index) {
  std::uint64_t bytes = 0;
  for (const SectionEntry& section : index.header().sections) {
    if (section.kind <= IndexSection::sheet_edges) bytes += section.bytes;
  }
  return bytes;
}

bool is_in_stored_order(const IndexHeader& header) {
  return header.tree.point_count > 0 && header.find(IndexSection::ids) == nullptr;
}

std::string spacing_text(const IndexHeader& header) {
  const int neighbours = header.tree.spacing_neighbours;
  return (neighbours > 0 ? fmt::format(", spacings to neighbour {}", neighbours) : "") +
         (header.tree.surface_unit > 0.0 ? ", surfaces" : "");
}

}  // namespace

Json index_json(const IndexFile& index, bool verified) {
  const IndexHeader& header = index.header();
  return {{"file", index.name()},
          {"version", k_index_version},
          {"bytes", header.file_bytes},
          {"bytes_per_point", bytes_per_point(index, header.file_bytes)},
          {"octree_bytes_per_point", bytes_per_point(index, octree_bytes(index))},
          {"organisation", organisation_name(header.tree.organisation)},
          {"levels", header.tree.level_count},
          {"nodes", header.tree.node_count},
          {"stored_order", is_in_stored_order(header)},
          {"spacing_neighbours", header.tree.spacing_neighbours},
          {"surfaces", header.tree.surface_unit > 0.0},
          {"verified", verified}};
}

std::vector<std::string> index_lines(const IndexFile& index, bool verified) {
  const IndexHeader& header = index.header();
  return {fmt::format("version {}, {} octree of {} nodes on {} levels{}", k_index_version,
                      organisation_name(header.tree.organisation), header.tree.node_count,
                      header.tree.level_count,
                      (is_in_stored_order(header) ? ", points in its order" : "") + spacing_text(header)),
          fmt::format("{} bytes, {:.2f} per point, {:.2f} of them octree{}", header.file_bytes,
                      bytes_per_point(index, header.file_bytes), bytes_per_point(index, octree_bytes(index)),
                      verified ? "; verified: undamaged" : "")};
}

}  // namespace alidade::tools
