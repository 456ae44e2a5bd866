// SPDX-License-Identifier: MIT
#include "tools/cloud/index_facts.h"

#include <fmt/format.h>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>

namespace alidade::tools {
namespace {

const char* organisation_name(Organisation organisation) {
  constexpr const char* k_names[] = {"adaptive", "fixed", "layered"};
  static_assert(std::size(k_names) == std::size_t(Organisation::layered) + 1);
  return k_names[static_cast<std::size_t>(organisation)];
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

nlohmann::ordered_json index_json(const IndexFile& index, bool verified) {
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
                      verified ? "; verified: intact" : "")};
}

}  // namespace alidade::tools
