// SPDX-License-Identifier: MIT
#include "octree/index_file/save_index.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <type_traits>

#include "base/error.h"
#include "base/fingerprint.h"
#include "base/output_file.h"
#include "base/parallel.h"
#include "octree/index_file/index_metadata.h"
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

  void begin(IndexSection kind) { begin(kind, element_bytes(kind)); }
  void begin(IndexSection kind, std::uint32_t value_bytes) {
    pad();
    entry_ = {kind, value_bytes, file_.size(), 0, 0};
    first_checksum_ = blocks_.sums().size();
  }

  /// Appends bytes to the section.
  void add(std::span<const std::byte> bytes) {
    entry_.bytes += bytes.size();
    blocks_.add(bytes);
  }
  /// add() for bytes of octree or columns, which are reported as written.
  void add_array(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const std::span<const std::byte> piece = bytes.first(std::min(bytes.size(), k_piece));
      bytes = bytes.subspan(piece.size());
      add(piece);
      if (options_.written) options_.written(piece);
    }
  }
  /// Appends colours as Color8. Requires multiples of a factor, 256 or 257.
  void add_shallow(std::span<const Color16> colors) {
    std::vector<Color8> shallow;
    while (!colors.empty()) {
      const auto piece = colors.first(std::min(colors.size(), k_piece / sizeof(Color16)));
      colors = colors.subspan(piece.size());
      shallow.resize(piece.size());
      std::ranges::transform(piece, shallow.begin(),
                             [](const Color16& color) { return Color8(color >> std::uint16_t{8}); });
      add(std::as_bytes(std::span(shallow)));
      if (options_.written) options_.written(std::as_bytes(piece));
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
  static constexpr std::size_t k_piece = std::size_t{1} << 26;

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

/// The factor with which Color8 represents them all; 1 if none does. Cost: one pass, in parallel, which ends
/// where none does.
std::uint16_t common_factor(std::span<const Color16> colors) {
  constexpr std::size_t k_block = 1 << 20;
  std::array<std::atomic<bool>, k_color_factors.size()> fails{};
  in_blocks(colors.size(), k_block, [&](std::size_t first, std::size_t end) {
    if (fails[0] && fails[1]) return;
    // Multiples of 257 are those whose bytes are equal, and of 256 those whose lower byte is 0.
    unsigned differences = 0, lower_bytes = 0;
    for (const Color16& color : colors.subspan(first, end - first)) {
      for (int channel = 0; channel < 3; ++channel) {
        differences |= (color[channel] >> 8) ^ (color[channel] & 255);
        lower_bytes |= color[channel] & 255;
      }
    }
    if (differences != 0) fails[0] = true;
    if (lower_bytes != 0) fails[1] = true;
  });
  for (std::size_t i = 0; i < k_color_factors.size(); ++i)
    if (!fails[i]) return k_color_factors[i];
  return 1;
}

std::uint64_t bytes_to_write(const Octree& octree, const PointCloud& cloud, const AttributeColumns& columns,
                             bool colors_are_shallow) {
  std::uint64_t bytes = octree.memory();
  for_each_column(columns, [&](Attribute attribute, const auto& column) {
    bytes += column.size() * element_bytes(column_section(attribute), colors_are_shallow);
  });
  for (const ExtraColumn& column : columns.extra_dimensions) bytes += column.values.size();
  for (const VariableLengthRecord& record : cloud.records) bytes += record.data.size();
  return bytes;
}

void write_tree(IndexWriter& writer, const TreeView& tree, const PointLayers& layers) {
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
  if (layers.spacings) {
    writer.write(IndexSection::spacings, std::span(layers.spacings, points + k_coordinate_padding));
    writer.write(IndexSection::slot_spacings,
                 std::span(layers.slot_spacings, std::size_t{k_node_width} * tree.node_count));
  }
  if (layers.surfaces) {
    writer.write(IndexSection::surfaces, std::span(layers.surfaces, points));
    writer.write(IndexSection::sheet_edges, std::span(layers.sheet_edges, points));
  }
}

void write_colors(IndexWriter& writer, const ColorColumn& colors, std::uint16_t factor) {
  const IndexSection kind = column_section(Attribute::color);
  writer.begin(kind, element_bytes(kind, factor > 1));
  if (!colors.shallow().empty())
    writer.add_array(std::as_bytes(colors.shallow()));
  else if (factor > 1)
    writer.add_shallow(colors.deep());
  else
    writer.add_array(std::as_bytes(colors.deep()));
  writer.end();
}

void write_cloud(IndexWriter& writer, const PointCloud& cloud, const AttributeColumns& columns,
                 std::uint16_t color_factor) {
  for_each_column(columns, [&](Attribute attribute, const auto& column) {
    if (column.empty()) return;
    if constexpr (std::is_same_v<decltype(column), const ColorColumn&>)
      write_colors(writer, column, color_factor);
    else
      writer.write(column_section(attribute), column);
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
  IndexHeader header;
  header.color_factor =
      columns.colors.deep().empty() ? columns.colors.factor() : common_factor(columns.colors.deep());
  IndexWriter writer(path, options, bytes_to_write(octree, cloud, columns, header.color_factor > 1));
  write_tree(writer, octree.view(), octree.layers());
  write_cloud(writer, cloud, columns, header.color_factor);
  header.tree = octree.view();
  header.layers = octree.layers();
  header.gps_time_is_standard = cloud.gps_time_is_standard;
  header.project_id = cloud.project_id;
  header.file_source_id = cloud.file_source_id;
  // An empty octree was never on any lattice but its cloud's.
  header.tree.lattice = cloud.lattice;
  writer.commit(std::move(header));
}

}  // namespace alidade
