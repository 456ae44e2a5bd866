// SPDX-License-Identifier: MIT
#include <algorithm>
#include <span>
#include <utility>

#include "base/huge_memory.h"
#include "base/remote_map.h"
#include "base/scratch_file.h"
#include "cloud/cloud_reader.h"
#include "cloud/lattice.h"
#include "cloud/rows.h"
#include "octree/index_file/index_file.h"
#include "octree/tree_walk.h"

namespace alidade {
namespace {

/// An index file as a cloud file: its points come back in the rows they had.
class IndexReader final : public CloudReader {
 public:
  explicit IndexReader(const InputFile& file) : index_(file) {
    about_.path = index_.name();
    about_.format = "Alidade index";
    about_.version = std::to_string(k_index_version);
    about_.point_count = index_.header().tree.point_count;
    if (about_.point_count > 0) about_.stated_bounds = index_.header().tree.bounds;
  }

  const CloudFile& file() const override { return about_; }
  std::vector<CloudFile> sources() const override {
    const std::vector<CloudFile>& files = index_.description().files;
    return files.empty() ? CloudReader::sources() : files;
  }
  AttributeSet attributes() const override { return index_.attributes(); }

  FileFacts facts() const override {
    const PointCloud& own = index_.description();
    const TreeView& tree = index_.header().tree;
    return {.crs = own.crs,
            .gps_time_is_standard = own.gps_time_is_standard,
            .project_id = own.project_id,
            .file_source_id = own.file_source_id,
            .box = widened_header_box(tree.bounds, tree.lattice)};
  }

  std::optional<Lattice> lattice() const override { return index_.header().tree.lattice; }
  std::optional<std::uint64_t> point_count() const override { return about_.point_count; }

  /// Each piece is a pass over the octree, since its points do not lie in the order of their rows.
  void read_in_pieces(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                      const Progress& progress) override {
    const PointCloud& own = index_.description();
    cloud.warnings.insert(cloud.warnings.end(), own.warnings.begin(), own.warnings.end());
    cloud.scanner_positions.insert(cloud.scanner_positions.end(), own.scanner_positions.begin(),
                                   own.scanner_positions.end());
    const std::vector<VariableLengthRecord> records = index_.records();
    cloud.records.insert(cloud.records.end(), records.begin(), records.end());
    const std::uint64_t bytes = index_.header().file_bytes;
    index_.tree();
    report(progress, bytes / 4, bytes);
    const AttributeSet kept = attributes() & wanted;
    std::uint64_t row = 0;
    do {
      const std::size_t count = room_in_piece(cloud, kept, about_.point_count - row, pieces);
      const Rows rows{static_cast<std::size_t>(row), count, cloud.size()};
      append_rows(cloud, kept, count);
      if (!recalls(pieces, cloud, count)) {
        take_positions(cloud, rows);
        take_columns(cloud, kept, rows);
      }
      row += count;
      RemoteMap::check(index_.tree().coordinates);
      report(progress, bytes / 4 + bytes / 4 * 3 / std::max<std::uint64_t>(1, about_.point_count) * row,
             bytes);
    } while (row < about_.point_count);
    report(progress, bytes, bytes);
  }

 private:
  /// Rows [first, first + count) of the index, and where they go in the cloud.
  struct Rows {
    std::size_t first, count, target;
  };

  void take_positions(PointCloud& cloud, const Rows& rows) const {
    const TreeView& tree = index_.tree();
    if (tree.point_count == 0) return;
    const LatticeShift shift(tree.lattice, cloud.lattice, index_.name());
    for_each_leaf(tree, [&](const Leaf& leaf) {
      for (std::uint32_t i = 0; i < leaf.count; ++i) {
        const std::size_t row = static_cast<std::size_t>(point_id(tree, leaf.first + i)) - rows.first;
        if (row >= rows.count) continue;
        cloud.positions[rows.target + row] = shift(position_of(tree, leaf, i));
      }
    });
  }

  void take_columns(PointCloud& cloud, AttributeSet kept, const Rows& rows) const {
    const auto copy = [&](const auto& own, auto& column, std::size_t width) {
      const auto part = own.subspan(rows.first * width, rows.count * width);
      std::copy(part.begin(), part.end(), column.begin() + static_cast<std::ptrdiff_t>(rows.target * width));
    };
    for_each_column(cloud, index_.columns(), [&](Attribute attribute, auto& column, const auto& own) {
      if (kept.contains(attribute)) copy(own, column, 1);
    });
    if (!kept.contains(Attribute::extra_dimensions)) return;
    const std::vector<ExtraColumn>& extra = index_.columns().extra_dimensions;
    for (std::size_t i = 0; i < extra.size(); ++i) {
      const std::size_t column = find_extra_dimension(cloud, extra[i].description,
                                                      occurrence_of(extra, i, &ExtraColumn::description));
      copy(extra[i].values, cloud.extra_dimensions[column].values,
           static_cast<std::size_t>(extra[i].description.byte_count));
    }
  }

  IndexFile index_;
  CloudFile about_;
};

/// Queries jump through an octree.
void prepare_for_queries(const Octree& octree) {
  if (octree.memory() <= available_memory().value_or(octree.memory())) return;
  const TreeView& tree = octree.view();
  const std::size_t count = tree.point_count;
  expect_random_reads(std::as_bytes(std::span(tree.nodes, tree.node_count)));
  expect_random_reads(std::as_bytes(std::span(tree.coordinates, 3 * count)));
  expect_random_reads(std::as_bytes(std::span(tree.ids, count)));
  expect_random_reads(std::as_bytes(std::span(tree.positions, tree.exact_count())));
}

}  // namespace

const CloudFormat k_index_format{
    .name = "Alidade index",
    .is_begun_by = [](std::span<const std::byte> start) { return is_index_file(start); },
    .open = [](InputFile file, Damage) -> std::unique_ptr<CloudReader> {
      return std::make_unique<IndexReader>(file);
    }};

CloudFormats index_and_file_formats() {
  static const std::vector<const CloudFormat*> formats = with_file_formats({&k_index_format});
  return formats;
}

IndexedCloud load_indexed_cloud(const CloudInputs& inputs, const IndexCloudOptions& options) {
  IndexedCloud loaded;
  const ScratchFolder folder = options.scratch ? ScratchFolder(options.scratch->folder) : std::nullopt;
  // Of heights in another unit nothing measured in the index is right.
  const CloudInput* const index = inputs.only(k_index_format);
  if (index != nullptr && !index->changes_heights()) {
    loaded.index = IndexFile(index->file());
    loaded.octree = loaded.index->octree(options.read.progress).with_scratch(folder);
    loaded.cloud = loaded.index->description();
    return loaded;
  }
  // Reading counts the work; what follows only checks for cancellation, at the count where reading ended.
  std::uint64_t done = 0, total = 0;
  ReadOptions read = options.read;
  read.progress = [&](std::uint64_t bytes, std::uint64_t all_bytes) {
    done = bytes;
    total = all_bytes;
    return !options.read.progress || options.read.progress(bytes, all_bytes);
  };
  if (options.scratch) {
    loaded.scratch = std::make_shared<ScratchCloud>(inputs, read, *options.scratch);
    loaded.cloud = loaded.scratch->facts();
  } else {
    loaded.cloud = read_cloud(inputs, read);
  }
  BuildOptions build_options = options.build;
  if (!build_options.progress) {
    build_options.progress = [&](std::uint64_t, std::uint64_t) { return read.progress(done, total); };
  }
  loaded.octree = options.scratch ? build_in_scratch(loaded.cloud.lattice, loaded.scratch->positions(),
                                                     *options.scratch, build_options)
                                  : build(std::move(loaded.cloud), build_options);
  if (options.scratch) prepare_for_queries(loaded.octree);
  return loaded;
}

}  // namespace alidade
