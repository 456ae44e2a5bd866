// SPDX-License-Identifier: MIT
#include "octree/index_file/index_file.h"

#include <fmt/format.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstring>
#include <mutex>
#include <span>
#include <utility>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/scratch_file.h"
#include "cloud/cloud_reader.h"
#include "cloud/lattice.h"
#include "cloud/rows.h"
#include "octree/index_file/check_tree.h"
#include "octree/index_file/index_header.h"
#include "octree/index_file/index_metadata.h"
#include "octree/index_file/index_sections.h"
#include "octree/tree_walk.h"

namespace alidade {
namespace {

AttributeColumns columns_in(const IndexSections& sections, const PointCloud& description) {
  AttributeColumns columns;
  for_each_column(columns, [&]<class Column>(Attribute attribute, Column& column) {
    const IndexSection kind = column_section(attribute);
    column = sections.values<std::remove_cvref_t<decltype(column[0])>>(kind);
    if constexpr (std::is_same_v<Column, ColorColumn>) {
      const std::uint16_t factor = sections.header().color_factor;
      if (factor > 1) column = ColorColumn(sections.values<Color8>(kind), factor);
    }
  });
  std::uint64_t bytes_per_point = 0;
  for (const ExtraDimension& dimension : description.extra_dimensions)
    bytes_per_point += static_cast<std::uint64_t>(dimension.byte_count);
  auto rest = sections.values<std::uint8_t>(IndexSection::extra_dimensions);
  const std::size_t points = sections.header().tree.point_count;
  if (rest.size() != bytes_per_point * points) {
    throw file_error(sections.name(), "wrong size of " + name(IndexSection::extra_dimensions),
                     fmt::format("{} bytes for each of {} points", bytes_per_point, points),
                     fmt::format("{} bytes", rest.size()));
  }
  for (const ExtraDimension& dimension : description.extra_dimensions) {
    const std::size_t bytes = static_cast<std::size_t>(dimension.byte_count) * points;
    columns.extra_dimensions.push_back({dimension, rest.first(bytes)});
    rest = rest.subspan(bytes);
  }
  return columns;
}

/// The data of the records must fill their section.
void check_record_bytes(const IndexSections& sections, const IndexMetadata& metadata) {
  const SectionEntry* const data = sections.header().find(IndexSection::record_data);
  std::uint64_t left = data != nullptr ? data->bytes : 0;
  for (const std::uint64_t bytes : metadata.record_bytes) {
    if (bytes > left) {
      throw file_error(sections.name(), "corrupt file: the data of the records exceeds its section",
                       fmt::format("at most {} bytes", left), std::to_string(bytes));
    }
    left -= bytes;
  }
  if (left > 0)
    throw file_error(sections.name(), "corrupt file: the section of record data is too long", {},
                     fmt::format("{} bytes more", left));
}

/// Points to the values of a section if the file has it.
template <class T>
void point_to(const IndexSections& sections, IndexSection kind, const T*& values) {
  if (sections.header().find(kind)) values = sections.values<T>(kind).data();
}

TreeView tree_in(const IndexSections& sections) {
  TreeView tree = sections.header().tree;
  point_to(sections, IndexSection::coordinates, tree.coordinates);
  point_to(sections, IndexSection::ids, tree.ids);
  point_to(sections, IndexSection::positions, tree.positions);
  return tree;
}

PointLayers layers_in(const IndexSections& sections) {
  PointLayers layers = sections.header().layers;
  point_to(sections, IndexSection::spacings, layers.spacings);
  point_to(sections, IndexSection::slot_spacings, layers.slot_spacings);
  point_to(sections, IndexSection::surfaces, layers.surfaces);
  point_to(sections, IndexSection::sheet_edges, layers.sheet_edges);
  return layers;
}

/// Throws the Error about what was found wrong, if anything.
void require_none(const IndexSections& sections, const std::optional<TreeFault>& fault) {
  if (!fault) return;
  // In the order of TreeFault::Array.
  constexpr IndexSection k_kinds[] = {IndexSection::nodes,       IndexSection::ids,
                                      IndexSection::coordinates, IndexSection::positions,
                                      IndexSection::spacings,    IndexSection::slot_spacings};
  static_assert(std::size(k_kinds) == std::size_t(TreeFault::Array::slot_spacings) + 1);
  const IndexSection kind = k_kinds[static_cast<std::size_t>(fault->array)];
  const std::uint64_t values = kind == IndexSection::coordinates ? 3 * fault->index : fault->index;
  sections.fail(kind, values * element_bytes(kind),
                kind == IndexSection::nodes ? fmt::format("node {}: {}", fault->index, fault->problem)
                                            : fault->problem);
}

/// Progress of work on one section after others.
Progress part_of(const Progress& progress, std::uint64_t before, std::uint64_t total) {
  if (!progress) return {};
  return [&progress, before, total](std::uint64_t done, std::uint64_t) {
    return progress(before + done, total);
  };
}

/// Copies the nodes out of the map and checks them and the ids. `tree` gets the copy.
HugeArray<Node> check_tree(const IndexSections& sections, TreeView& tree, const Progress& progress) {
  const std::span<const std::byte> stored = sections.bytes(IndexSection::nodes);
  const std::uint64_t nodes = stored.size();
  const std::uint64_t total = nodes + sections.bytes(IndexSection::ids).size();
  HugeArray<Node> copy(tree.node_count);
  tree.nodes = copy.data();
  // The checksums first, since they name damage best; the links, which one thread goes along, beside the ids.
  sections.check(
      IndexSection::nodes, part_of(progress, 0, total), [&](std::uint64_t begin, std::uint64_t end) {
        std::memcpy(reinterpret_cast<std::byte*>(copy.data()) + begin, stored.data() + begin, end - begin);
      });
  const auto check_ids = [&](std::uint64_t begin, std::uint64_t end) {
    const std::size_t first = begin / sizeof(std::uint32_t);
    auto bad = find_bad_id(
        sections.values<std::uint32_t>(IndexSection::ids).subspan(first, end / sizeof(std::uint32_t) - first),
        tree.point_count);
    if (bad) bad->index += first;
    require_none(sections, bad);
  };
  tbb::parallel_invoke(
      [&] { require_none(sections, find_broken_link(tree)); },
      [&] { sections.check(IndexSection::ids, part_of(progress, nodes, total), check_ids); });
  return copy;
}

/// An index file as a cloud file: its points come back in the rows they had.
class IndexReader final : public CloudReader {
 public:
  explicit IndexReader(const InputFile& file) : index_(file) {
    const PointCloud& own = index_.description();
    const TreeView& tree = index_.header().tree;
    facts_ = {.sources = own.files,
              .bytes = index_.header().file_bytes,
              .attributes = index_.attributes(),
              .lattice = tree.lattice,
              .point_count = tree.point_count,
              .crs = own.crs,
              .gps_time_is_standard = own.gps_time_is_standard,
              .project_id = own.project_id,
              .file_source_id = own.file_source_id,
              .box = widened_header_box(tree.bounds, tree.lattice)};
    facts_.file.path = index_.name();
    facts_.file.format = "Alidade index";
    facts_.file.version = std::to_string(k_index_version);
    facts_.file.point_count = tree.point_count;
    if (tree.point_count > 0) facts_.file.stated_bounds = tree.bounds;
  }

  /// Each piece is a pass over the octree, since its points do not lie in the order of their rows.
  FileRead read(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                const Progress& progress) override {
    const PointCloud& own = index_.description();
    cloud.warnings.insert(cloud.warnings.end(), own.warnings.begin(), own.warnings.end());
    cloud.scanner_positions.insert(cloud.scanner_positions.end(), own.scanner_positions.begin(),
                                   own.scanner_positions.end());
    const std::vector<VariableLengthRecord> records = index_.records();
    cloud.records.insert(cloud.records.end(), records.begin(), records.end());
    const std::uint64_t bytes = index_.header().file_bytes;
    // Of a remote file, fetching takes nearly all the time.
    const std::uint64_t begin = is_remote_name(index_.name()) ? bytes - bytes / 16 : bytes / 4;
    index_.tree([&](std::uint64_t done, std::uint64_t total) {
      return !progress ||
             progress(static_cast<std::uint64_t>(static_cast<double>(begin) * static_cast<double>(done) /
                                                 static_cast<double>(total)),
                      bytes);
    });
    report(progress, begin, bytes);
    const AttributeSet kept = facts_.attributes & wanted;
    const std::uint64_t all = facts_.file.point_count;
    std::uint64_t row = 0;
    do {
      const std::size_t count = room_in_piece(cloud, kept, all - row, pieces);
      const Rows rows{static_cast<std::size_t>(row), count, cloud.size()};
      append_rows(cloud, kept, count);
      if (!recalls(pieces, cloud, count)) {
        take_positions(cloud, rows);
        take_columns(cloud, kept, rows);
      }
      row += count;
      report(progress, begin + (bytes - begin) / std::max<std::uint64_t>(1, all) * row, bytes);
    } while (row < all);
    report(progress, bytes, bytes);
    return {.files = facts_.source_files()};
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

struct IndexFile::State {
  explicit State(const InputFile& file)
      : sections(file),
        metadata(read_index_metadata(sections.read(IndexSection::metadata),
                                     sections.header().find(IndexSection::metadata)->offset,
                                     sections.name())) {
    check_record_bytes(sections, metadata);
    PointCloud& cloud = metadata.cloud;
    cloud.lattice = sections.header().tree.lattice;
    cloud.gps_time_is_standard = sections.header().gps_time_is_standard;
    cloud.project_id = sections.header().project_id;
    cloud.file_source_id = sections.header().file_source_id;
    if (sections.is_mapped()) map({});
  }

  /// Makes columns and tree, for which a remote file is fetched. Returns whether it was.
  bool map(const Progress& progress) {
    bool is_fetched = false;
    std::call_once(is_mapped, [&] {
      is_fetched = !sections.is_mapped();
      sections.map(progress);
      columns = columns_in(sections, metadata.cloud);
      tree = tree_in(sections);
      layers = layers_in(sections);
    });
    return is_fetched;
  }

  IndexSections sections;
  IndexMetadata metadata;
  AttributeColumns columns;
  /// Nodes are where a query begins and waits most: out of the map, on huge pages, they make it a tenth to a
  /// fifth faster; and what was checked cannot change any more.
  HugeArray<Node> nodes;
  TreeView tree;  ///< without nodes until they are checked
  PointLayers layers;
  std::once_flag is_mapped;
  std::mutex checking;
  bool tree_is_checked = false;
};

IndexFile::IndexFile(const InputFile& file) : state_(std::make_shared<State>(file)) {}

const std::string& IndexFile::name() const {
  return state_->sections.name();
}

const IndexHeader& IndexFile::header() const {
  return state_->sections.header();
}

const PointCloud& IndexFile::description() const {
  return state_->metadata.cloud;
}

const AttributeColumns& IndexFile::columns() const {
  state_->map({});
  return state_->columns;
}

AttributeSet IndexFile::attributes() const {
  AttributeSet set;
  for (std::uint32_t bit = 1; bit <= static_cast<std::uint32_t>(Attribute::extra_dimensions); bit <<= 1) {
    const auto attribute = static_cast<Attribute>(bit);
    if (header().find(column_section(attribute))) set = set | attribute;
  }
  return set;
}

std::vector<VariableLengthRecord> IndexFile::records() const {
  const std::vector<std::byte> stored = state_->sections.read(IndexSection::record_data);
  std::vector<VariableLengthRecord> records = state_->metadata.cloud.records;
  const auto* next = reinterpret_cast<const std::uint8_t*>(stored.data());
  for (std::size_t i = 0; i < records.size(); ++i) {
    const std::uint8_t* const begin = std::exchange(next, next + state_->metadata.record_bytes[i]);
    records[i].data.assign(begin, next);
  }
  return records;
}

const TreeView& IndexFile::tree(const Progress& progress) const {
  const std::scoped_lock lock(state_->checking);
  if (state_->tree_is_checked) return state_->tree;
  // What is fetched is all that counts.
  const std::uint64_t all = header().file_bytes;
  const Progress none_left = [&](std::uint64_t, std::uint64_t) { return !progress || progress(all, all); };
  const Progress& left = state_->map(progress) ? none_left : progress;
  // Isolated: a thread that waits in here must not take up a task that waits for the lock it holds.
  tbb::this_task_arena::isolate([&] { state_->nodes = check_tree(state_->sections, state_->tree, left); });
  state_->tree_is_checked = true;
  return state_->tree;
}

Octree IndexFile::octree(const Progress& progress) const {
  const TreeView& tree = this->tree(progress);
  return Octree(tree, state_, usable(InstructionSet::best)).with_layers(state_->layers).with_mapped(true);
}

void IndexFile::verify(const Progress& progress) const {
  const IndexSections& sections = state_->sections;
  state_->map(progress);
  for (const SectionEntry& section : header().sections)
    sections.check(section.kind, part_of(progress, section.offset, header().file_bytes));
  sections.check_gaps();
  const PointLayers& layers = state_->layers;
  require_none(sections, find_misplaced_point(tree(), layers));
  if (layers.spacings) require_none(sections, find_bad_slot_spacing(tree(), layers));
  report(progress, header().file_bytes, header().file_bytes);
}

IndexFile open_index(const std::filesystem::path& path) {
  return IndexFile(InputFile(path));
}

void verify_index(const std::filesystem::path& path, const Progress& progress) {
  open_index(path).verify(progress);
}

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

AttributeColumns IndexedCloud::columns() const {
  return index ? index->columns() : large ? large->columns() : columns_of(cloud);
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
    loaded.large = options.read_large(inputs, read, *options.scratch);
    loaded.cloud = loaded.large->facts();
  } else {
    loaded.cloud = read_cloud(inputs, read);
  }
  BuildOptions build_options = options.build;
  if (!build_options.progress) {
    build_options.progress = [&](std::uint64_t, std::uint64_t) { return read.progress(done, total); };
  }
  loaded.octree = options.scratch ? build_in_scratch(loaded.cloud.lattice, loaded.large->positions(),
                                                     *options.scratch, build_options)
                                  : build(std::move(loaded.cloud), build_options);
  if (options.scratch) prepare_for_queries(loaded.octree);
  return loaded;
}

}  // namespace alidade
