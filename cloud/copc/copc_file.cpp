// SPDX-License-Identifier: MIT
#include "cloud/copc/copc_file.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "base/bytes.h"
#include "base/error.h"
#include "base/parallel.h"
#include "cloud/input_view.h"
#include "cloud/las/las_columns.h"
#include "cloud/laz/chunk_codec.h"
#include "cloud/read_in_pieces.h"
#include "cloud/rows.h"

namespace alidade {

CopcInfo parse_copc_info(std::span<const std::byte> data, const std::string& file_name,
                         std::uint64_t offset) {
  const HeaderFields fields(data, file_name, offset);
  constexpr std::size_t k_size = 160;
  fields.require(data.size() == k_size, 0, "wrong size of the COPC record", fmt::format("{} bytes", k_size),
                 data.size());
  CopcInfo info;
  info.half_size = fields.get<double>(24);
  // The cube's side is twice as long and must be a number, too.
  fields.require(std::isfinite(2 * info.half_size) && info.half_size > 0, 24,
                 "invalid size of the COPC octree", "a positive number", info.half_size);
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t byte = 8 * static_cast<std::size_t>(axis);
    info.centre[axis] = fields.get<double>(byte);
    fields.require(std::isfinite(std::abs(info.centre[axis]) + 2 * info.half_size), byte,
                   "invalid centre of the COPC octree", "a finite number", info.centre[axis]);
  }
  info.spacing = fields.get<double>(32);
  fields.require(std::isfinite(info.spacing) && info.spacing > 0, 32, "invalid spacing of the COPC octree",
                 "a positive number", info.spacing);
  info.root_page = fields.get<std::uint64_t>(40);
  info.root_page_size = fields.get<std::uint64_t>(48);
  return info;
}

namespace {

constexpr std::uint64_t k_entry_size = 32;
constexpr std::int32_t k_page_entry = -1;  // the point count of an entry that points to another page

struct Page {
  std::uint64_t offset, size;
};

/// The entries of all pages of the hierarchy, checked one by one.
class Entries {
 public:
  explicit Entries(InputFile& file) : file_(file) {}

  std::map<CopcKey, LazChunk> read(const Page& root) {
    announce(root, 0);
    while (!pages_.empty()) {
      const Page page = pages_.back();
      pages_.pop_back();
      read_page(page);
    }
    return std::move(nodes_);
  }

 private:
  /// Checks a page that the bytes at `from` point to; it is read later.
  void announce(const Page& page, std::uint64_t from) {
    const std::string referrer = from == 0 ? "the COPC record" : fmt::format("byte {}", from);
    const bool inside = page.offset <= file_.size() && page.size <= file_.size() - page.offset;
    if (!inside || page.size == 0 || page.size % k_entry_size != 0) {
      fail_at_byte(file_.name(), page.offset,
                   fmt::format("invalid page of the COPC hierarchy, referenced by {}", referrer),
                   fmt::format("a multiple of {} bytes inside the file", k_entry_size),
                   std::to_string(page.size));
    }
    if (!offsets_.insert(page.offset).second) {
      fail_at_byte(file_.name(), page.offset, "page of the COPC hierarchy referenced more than once",
                   "one reference", "a second one from " + referrer);
    }
    // Overlapping pages could be far more than the file has room for.
    bytes_ += page.size;
    if (bytes_ > file_.size()) {
      fail_at_byte(file_.name(), page.offset, "the pages of the COPC hierarchy exceed the file",
                   fmt::format("at most {}", file_.size()), std::to_string(bytes_));
    }
    pages_.push_back(page);
  }

  void read_page(const Page& page) {
    constexpr std::uint64_t k_block_size = 2048 * k_entry_size;
    for (std::uint64_t done = 0; done < page.size; done += block_.size()) {
      block_.resize(static_cast<std::size_t>(std::min(k_block_size, page.size - done)));
      file_.read_at(page.offset + done, block_);
      for (std::size_t at = 0; at < block_.size(); at += k_entry_size)
        read_entry(block_.data() + at, page.offset + done + at);
    }
  }

  void read_entry(const std::byte* at, std::uint64_t offset) {
    const CopcKey key{load<std::int32_t>(at), load<std::int32_t>(at + 4), load<std::int32_t>(at + 8),
                      load<std::int32_t>(at + 12)};
    const std::uint64_t target = load<std::uint64_t>(at + 16);
    const std::int32_t size = load<std::int32_t>(at + 24), count = load<std::int32_t>(at + 28);
    const bool level_exists = key.level >= 0 && key.level <= k_deepest_copc_level;
    const std::int64_t end = level_exists ? std::int64_t{1} << key.level : 0;
    const auto on_level = [end](std::int32_t number) { return number >= 0 && number < end; };
    if (!level_exists || !on_level(key.x) || !on_level(key.y) || !on_level(key.z)) {
      fail_at_byte(file_.name(), offset, "invalid key in the COPC hierarchy",
                   fmt::format("a level from 0 to {} and indices on it", k_deepest_copc_level), key.name());
    }
    if (count < k_page_entry) {
      fail_at_byte(file_.name(), offset + 28,
                   fmt::format("invalid number of points of COPC node {}", key.name()), "-1 or more",
                   std::to_string(count));
    }
    if (count == k_page_entry) {
      announce({target, static_cast<std::uint64_t>(std::max(size, 0))}, offset);
      return;
    }
    LazChunk& chunk = nodes_[key];
    if (count == 0) return;
    if (chunk.point_count != 0) {
      fail_at_byte(file_.name(), offset, fmt::format("duplicate node {} in the COPC hierarchy", key.name()),
                   "one with points", fmt::format("{} and {} points", chunk.point_count, count));
    }
    chunk = {target, static_cast<std::uint64_t>(std::max(size, 0)), static_cast<std::uint64_t>(count)};
  }

  InputFile& file_;
  std::vector<Page> pages_;  ///< still to be read
  std::set<std::uint64_t> offsets_;
  std::uint64_t bytes_ = 0;
  std::vector<std::byte> block_;  ///< of a page
  std::map<CopcKey, LazChunk> nodes_;
};

/// Makes every node a child of the smallest cube around it that is a node.
void find_children(CopcHierarchy& hierarchy) {
  std::vector<CopcNode>& nodes = hierarchy.nodes;
  std::vector<std::uint32_t> parents(nodes.size());
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    CopcKey key = nodes[i].key;
    auto parent = nodes.end();
    // Ends at the root, which is a node and contains all cubes.
    do {
      key = key.parent();
      parent = std::ranges::lower_bound(nodes, key, {}, &CopcNode::key);
    } while (parent->key != key);
    parents[i] = static_cast<std::uint32_t>(parent - nodes.begin());
    ++parent->child_count;
  }
  std::uint32_t end = 0;
  for (CopcNode& node : nodes) {
    node.first_child = end;
    end += std::exchange(node.child_count, 0);
  }
  hierarchy.children.resize(end);
  for (std::uint32_t i = 1; i < nodes.size(); ++i) {
    CopcNode& parent = nodes[parents[i]];
    hierarchy.children[parent.first_child + parent.child_count++] = i;
  }
}

/// Sets the rows of every node to those of its chunk.
void find_rows(const std::string& file_name, std::span<const LazChunk> chunks, std::vector<CopcNode>& nodes) {
  std::vector<CopcNode*> in_file;
  for (CopcNode& node : nodes) {
    if (node.chunk.point_count > 0) in_file.push_back(&node);
  }
  std::ranges::sort(in_file, {}, [](const CopcNode* node) { return node->chunk.offset; });
  std::uint64_t row = 0;
  for (std::size_t i = 0; i < in_file.size(); ++i) {
    if (i >= chunks.size() || in_file[i]->chunk != chunks[i]) {
      const LazChunk& chunk = in_file[i]->chunk;
      fail_at_byte(file_name, chunk.offset,
                   fmt::format("COPC node {} does not match a chunk of the file", in_file[i]->key.name()),
                   i < chunks.size() ? fmt::format("{} points in {} bytes at byte {}", chunks[i].point_count,
                                                   chunks[i].byte_count, chunks[i].offset)
                                     : "no further chunk",
                   fmt::format("{} points in {} bytes", chunk.point_count, chunk.byte_count));
    }
    in_file[i]->first_row = row;
    row += chunks[i].point_count;
  }
  if (in_file.size() < chunks.size()) {
    fail_at_byte(file_name, chunks[in_file.size()].offset,
                 "the COPC hierarchy does not reference a chunk of the file",
                 fmt::format("{} nodes with points", chunks.size()), std::to_string(in_file.size()));
  }
}

constexpr std::size_t k_start_size = 589;  // header, record header and the record of COPC

[[noreturn]] void not_copc(const std::string& file_name, std::string expected, std::string found) {
  throw Error(file_name, {}, "not a COPC 1.0 file", std::move(expected), std::move(found));
}

LazLayout read_layout(const std::string& file_name, const LasHeader& header, const LasRecords& records) {
  if (!records.copc_info || !header.compressed || !records.laszip) {
    not_copc(file_name, "compressed points and a COPC record first", "");
  }
  if (header.version_minor != 4 || header.point_format < 6 || header.point_format > 8) {
    not_copc(file_name, "LAS 1.4 with point format 6, 7 or 8",
             fmt::format("LAS 1.{} with point format {}", header.version_minor, header.point_format));
  }
  const LazLayout layout = parse_laszip_record(records.laszip->data, file_name, records.laszip->offset,
                                               header.point_format, header.point_size);
  if (layout.compressor != LazCompressor::layered || layout.chunk_size != 0) {
    not_copc(file_name, "layered chunks of variable size",
             fmt::format("compressor {} and chunks of {} points", static_cast<int>(layout.compressor),
                         layout.chunk_size));
  }
  return layout;
}

std::vector<LazChunk> find_chunks(InputFile& file, const LasHeader& header, const LazLayout& layout,
                                  std::vector<std::string>& warnings) {
  std::string missing;
  if (std::optional<std::vector<LazChunk>> chunks = read_chunk_table(file, header, layout, missing)) {
    return std::move(*chunks);
  }
  warnings.push_back(fmt::format("{}: {}; locating the chunks one by one", file.name(), missing));
  WalkedChunks walked = walk_layered_chunks(file, header, layout);
  if (walked.problem) throw Error(*walked.problem);
  return std::move(walked.chunks);
}

std::uint64_t point_count_of(const ChosenNodes& part) {
  std::uint64_t count = 0;
  for (const std::uint32_t node : part.nodes) count += part.file->hierarchy().nodes[node].chunk.point_count;
  return count;
}

/// Unpacks the nodes of one file into existing rows of the cloud, from `first_row` on.
void unpack(const ChosenNodes& part, const LasColumns& columns, const LasColumns::Choice& choice,
            std::size_t first_row, PointCloud& cloud, JoinedProgress& progress) {
  const CopcFile& file = *part.file;
  const std::size_t point_size = file.header().point_size;
  std::vector<std::size_t> first_rows;
  for (const std::uint32_t node : part.nodes) {
    first_rows.push_back(first_row);
    first_row += static_cast<std::size_t>(file.hierarchy().nodes[node].chunk.point_count);
  }
  struct Workshop {  // of a thread
    ChunkDecoder decoder;
    std::vector<std::byte> bytes;
  };
  tbb::enumerable_thread_specific<Workshop> workshops([&] {
    return Workshop{ChunkDecoder(file.layout(), layers_of(choice.kept)), {}};
  });
  in_parallel(part.nodes.size(), 1, [&](std::size_t i) {
    const CopcNode& node = file.hierarchy().nodes[part.nodes[i]];
    if (node.chunk.point_count == 0) return;
    Workshop& workshop = workshops.local();
    file.read_chunk(node, workshop.bytes);
    try {
      workshop.decoder.decode(
          workshop.bytes, node.chunk.point_count,
          [&](const std::byte* records, std::size_t count, std::uint64_t first) {
            columns.take({records, point_size, count, first_rows[i] + static_cast<std::size_t>(first)},
                         choice, cloud);
          });
    } catch (const CorruptChunk& problem) {
      throw Error(file.name(), fmt::format("COPC node {}", node.key.name()),
                  fmt::format("corrupt compressed points: {}", problem.what()));
    }
    progress.add(node.chunk.point_count);
  });
}

}  // namespace

std::string CopcKey::name() const {
  return fmt::format("{}-{}-{}-{}", level, x, y, z);
}

Bounds copc_cube(const CopcInfo& info, const CopcKey& key) {
  const double side = 2 * info.half_size / static_cast<double>(std::int64_t{1} << key.level);
  const glm::dvec3 min = info.centre - info.half_size + side * glm::dvec3(key.x, key.y, key.z);
  return {min, min + side};
}

CopcHierarchy read_copc_hierarchy(InputFile& file, const CopcInfo& info, std::span<const LazChunk> chunks) {
  CopcHierarchy hierarchy;
  {
    std::map<CopcKey, LazChunk> found = Entries(file).read({info.root_page, info.root_page_size});
    found.try_emplace(CopcKey{});
    hierarchy.nodes.reserve(found.size());
    for (const auto& [key, chunk] : found) hierarchy.nodes.push_back({.key = key, .chunk = chunk});
  }
  find_children(hierarchy);
  find_rows(file.name(), chunks, hierarchy.nodes);
  return hierarchy;
}

bool is_copc(std::span<const std::byte> start) {
  return start.size() >= k_start_size && las_text(start.data(), 4) == "LASF" &&
         las_text(start.data() + k_las_header_size + 2, 16) == "copc" &&
         load<std::uint16_t>(start.data() + k_las_header_size + 18) == 1;
}

CopcFile::CopcFile(InputFile file, bool rests, const CloudInput* input)
    : file_(std::move(file)),
      rests_(rests),
      header_(read_las_header(file_, warnings_)),
      records_(read_las_records(file_, header_, warnings_)),
      layout_(read_layout(file_.name(), header_, records_)),
      info_(parse_copc_info(records_.copc_info->data, file_.name(), records_.copc_info->offset)),
      hierarchy_(read_copc_hierarchy(file_, info_, find_chunks(file_, header_, layout_, warnings_))) {
  if (rests_) file_.rest();
  if (input == nullptr || input->view == nullptr || input->is_changed()) return;
  FileFacts facts;
  facts.crs = records_.crs;
  const ReferenceChange change = input->view->change_of(*input, facts);
  if (change.height_factor == 1.0) return;
  height_factor_ = change.height_factor;
  records_.crs = change.crs;
  for (double* const height :
       {&header_.lattice.scale.z, &header_.lattice.offset.z, &header_.bounds.min.z, &header_.bounds.max.z})
    *height *= height_factor_;
  warnings_.push_back(name() + ": " + change.heights_note);
}

void CopcFile::read_chunk(const CopcNode& node, std::vector<std::byte>& bytes) const {
  bytes.resize(static_cast<std::size_t>(node.chunk.byte_count));
  const std::lock_guard lock(mutex_);
  file_.read_at(node.chunk.offset, bytes);
  if (rests_) file_.rest();
}

Bounds CopcFile::bounds(const CopcNode& node) const {
  Bounds bounds = copc_cube(info_, node.key);
  const int levels_below = k_deepest_copc_level + 1 - node.key.level;
  for (int axis = 0; axis < 3; ++axis) {
    // A cube's faces are sums of three numbers, each rounded: the error is a few ulps of the largest.
    const double largest = std::abs(info_.centre[axis]) + 2 * info_.half_size;
    const double rounding = 8 * std::numeric_limits<double>::epsilon() * largest * levels_below;
    if (axis == 2) {
      bounds.min.z *= height_factor_;
      bounds.max.z *= height_factor_;
    }
    const double margin = header_.lattice.scale[axis] + rounding * std::max(1.0, height_factor_);
    bounds.min[axis] -= margin;
    bounds.max[axis] += margin;
  }
  return bounds;
}

PointCloud read_copc_nodes(std::span<const ChosenNodes> parts, const ReadOptions& options) {
  PointCloud cloud;
  std::vector<Lattice> lattices;
  Bounds bounds;
  for (const ChosenNodes& part : parts) {
    lattices.push_back(part.file->header().lattice);
    bounds.grow(part.file->header().bounds);
  }
  if (!parts.empty()) cloud.lattice = joined_lattice(lattices, bounds);
  JoinedProgress progress(options.progress, point_count(parts));
  std::vector<ColoredRows> colored;
  for (const ChosenNodes& part : parts) {
    const CopcFile& file = *part.file;
    if (&part == &parts.front()) cloud.crs = file.records().crs;
    const LasColumns columns(file.name(), file.header(), file.records().extra_dimensions);
    const LasColumns::Choice choice = columns.choose(options.attributes, cloud);
    const std::size_t first_row = cloud.size();
    append_rows(cloud, choice.kept, static_cast<std::size_t>(point_count_of(part)));
    unpack(part, columns, choice, first_row, cloud, progress);
    if (choice.kept.contains(Attribute::color)) colored.push_back({file.name(), first_row, cloud.size()});
    CloudFile about;
    about.path = file.name();
    about.format = "COPC";
    about.version = "1.4";
    about.point_format = file.header().point_format;
    about.point_count = cloud.size() - first_row;
    cloud.files.push_back(std::move(about));
  }
  measure_colors(cloud, 0, colored);
  apply(choose_spread(std::move(colored), options.color_depth, cloud.warnings), cloud);
  return cloud;
}

std::uint64_t point_count(std::span<const ChosenNodes> parts) {
  std::uint64_t count = 0;
  for (const ChosenNodes& part : parts) count += point_count_of(part);
  return count;
}

}  // namespace alidade
