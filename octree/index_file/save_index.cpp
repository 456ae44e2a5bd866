// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/error.h"
#include "base/fingerprint.h"
#include "base/output_file.h"
#include "octree/index_file/index_file.h"
#include "octree/index_file/index_sections.h"

namespace alidade {
namespace {

/// Writes section after section, and in the end the page that states where they are.
class IndexWriter {
 public:
  IndexWriter(const std::filesystem::path& path, const SaveIndexOptions& options, std::uint64_t total)
      : file_(path, options.overwrite), options_(options), total_(total) {
    file_.write(std::array<std::byte, k_index_page>{});
  }

  void begin(IndexSection kind) {
    pad();
    entry_ = {kind, element_bytes(kind), file_.size(), 0, 0};
    first_checksum_ = blocks_.sums().size();
  }

  /// Appends bytes to the section.
  void add(std::span<const std::byte> bytes) {
    entry_.bytes += bytes.size();
    blocks_.add(bytes);
  }
  /// The same with bytes of octree or columns.
  void add_array(std::span<const std::byte> bytes) {
    constexpr std::size_t k_piece = std::size_t{1} << 26;
    while (!bytes.empty()) {
      const std::span<const std::byte> piece = bytes.first(std::min(bytes.size(), k_piece));
      bytes = bytes.subspan(piece.size());
      add(piece);
      if (options_.written) options_.written(piece);
    }
  }
  void end() {
    blocks_.end();
    const auto run = std::span(blocks_.sums()).subspan(first_checksum_);
    entry_.checksum = checksum(std::as_bytes(run));
    header_.sections.push_back(entry_);
  }

  template <class T>
  void write(IndexSection kind, std::span<const T> values) {
    begin(kind);
    add_array(std::as_bytes(values));
    end();
  }

  void commit(IndexHeader header) {
    write_checksums();
    header.sections = std::move(header_.sections);
    header.file_bytes = file_.size();
    file_.write_at(0, encode_index_header(header));
    file_.commit();
  }

 private:
  void pad() {
    static constexpr std::array<std::byte, k_index_page> k_zeros{};
    file_.write(
        std::span(k_zeros).first(static_cast<std::size_t>(align_to_page(file_.size()) - file_.size())));
  }
  void write_checksums() {
    pad();
    const auto bytes = std::as_bytes(std::span(blocks_.sums()));
    header_.sections.push_back({IndexSection::checksums, element_bytes(IndexSection::checksums), file_.size(),
                                bytes.size(), checksum(bytes)});
    file_.write(bytes);
  }

  OutputFile file_;
  const SaveIndexOptions& options_;
  std::uint64_t total_;
  IndexHeader header_;
  SectionEntry entry_;
  ChecksumBlocks blocks_{[this](std::span<const std::byte> block) {
    file_.write(block);
    report(options_.progress, std::min(file_.size(), total_), total_);
  }};
  std::size_t first_checksum_ = 0;
};

void check_cloud(const Octree& octree, const PointCloud& cloud, const AttributeColumns& columns) {
  if (octree.size() > 0 && cloud.lattice != octree.lattice())
    throw Error({.problem = "octree and cloud have different lattices"});
  for_each_column(columns, [&](Attribute attribute, const auto& column) {
    if (column.empty() || column.size() == octree.size()) return;
    throw input_error("wrong column size: " + attribute_names(attribute).front(),
                      fmt::format("{} values", octree.size()), std::to_string(column.size()));
  });
  for (const ExtraColumn& column : columns.extra_dimensions) {
    const std::size_t bytes = octree.size() * static_cast<std::size_t>(column.description.byte_count);
    check_that(column.values.size() == bytes, "wrong column size: " + column.description.name,
               fmt::format("{} bytes", bytes), std::to_string(column.values.size()));
  }
}

std::uint64_t bytes_to_write(const Octree& octree, const PointCloud& cloud, const AttributeColumns& columns) {
  std::uint64_t bytes = octree.memory();
  for_each_column(columns, [&](Attribute, const auto& column) { bytes += column.size_bytes(); });
  for (const ExtraColumn& column : columns.extra_dimensions) bytes += column.values.size();
  for (const VariableLengthRecord& record : cloud.records) bytes += record.data.size();
  return bytes;
}

void write_tree(IndexWriter& writer, const TreeView& tree) {
  const std::size_t points = tree.point_count;
  writer.write(IndexSection::nodes, std::span(tree.nodes, tree.node_count));
  writer.begin(IndexSection::coordinates);
  writer.add_array(std::as_bytes(std::span(tree.coordinates, 3 * points)));
  // Written as zeros, whatever is in memory there.
  constexpr std::array<std::uint16_t, k_coordinate_padding> k_padding{};
  writer.add(std::as_bytes(std::span(k_padding)));
  writer.end();
  if (tree.ids) writer.write(IndexSection::ids, std::span(tree.ids, points));
  if (tree.positions) writer.write(IndexSection::positions, std::span(tree.positions, tree.exact_count()));
  if (tree.spacings) {
    writer.write(IndexSection::spacings, std::span(tree.spacings, points + k_coordinate_padding));
    writer.write(IndexSection::slot_spacings,
                 std::span(tree.slot_spacings, std::size_t{k_node_width} * tree.node_count));
  }
  if (tree.surfaces) {
    writer.write(IndexSection::surfaces, std::span(tree.surfaces, points));
    writer.write(IndexSection::sheet_edges, std::span(tree.sheet_edges, points));
  }
}

void write_cloud(IndexWriter& writer, const PointCloud& cloud, const AttributeColumns& columns) {
  for_each_column(columns, [&](Attribute attribute, const auto& column) {
    if (!column.empty()) writer.write(column_section(attribute), column);
  });
  if (!columns.extra_dimensions.empty()) {
    writer.begin(IndexSection::extra_dimensions);
    for (const ExtraColumn& column : columns.extra_dimensions) writer.add_array(std::as_bytes(column.values));
    writer.end();
  }
  writer.begin(IndexSection::metadata);
  writer.add(encode_index_metadata(cloud));
  writer.end();
  writer.begin(IndexSection::record_data);
  for (const VariableLengthRecord& record : cloud.records) writer.add(std::as_bytes(std::span(record.data)));
  writer.end();
}

}  // namespace

void save_index(const std::filesystem::path& path, const Octree& octree, const PointCloud& cloud,
                const SaveIndexOptions& options) {
  save_index(path, octree, cloud, columns_of(cloud), options);
}

void save_index(const std::filesystem::path& path, const Octree& octree, const PointCloud& cloud,
                const AttributeColumns& columns, const SaveIndexOptions& options) {
  check_cloud(octree, cloud, columns);
  IndexWriter writer(path, options, bytes_to_write(octree, cloud, columns));
  write_tree(writer, octree.view());
  write_cloud(writer, cloud, columns);
  IndexHeader header;
  header.tree = octree.view();
  header.gps_time_is_standard = cloud.gps_time_is_standard;
  header.project_id = cloud.project_id;
  header.file_source_id = cloud.file_source_id;
  // An empty octree was never on any lattice but its cloud's.
  header.tree.lattice = cloud.lattice;
  writer.commit(std::move(header));
}

}  // namespace alidade
