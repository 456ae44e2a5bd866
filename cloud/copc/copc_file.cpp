// SPDX-License-Identifier: MIT
#include "cloud/copc/copc_file.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/bytes.h"
#include "base/error.h"
#include "base/parallel.h"
#include "cloud/las/read_las.h"
#include "cloud/lattice.h"
#include "cloud/laz/chunk_codec.h"
#include "cloud/laz/chunk_table.h"
#include "cloud/read_in_pieces.h"
#include "cloud/rows.h"

namespace alidade {
namespace {

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

/// Unpacks the nodes of one file into rows that the cloud has already, from `first_row` on.
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
  at_once(std::size_t{0}, part.nodes.size(), [&](std::size_t i) {
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

bool is_copc(std::span<const std::byte> start) {
  return start.size() >= k_start_size && las_text(start.data(), 4) == "LASF" &&
         las_text(start.data() + k_las_header_size + 2, 16) == "copc" &&
         load<std::uint16_t>(start.data() + k_las_header_size + 18) == 1;
}

CopcFile::CopcFile(InputFile file)
    : file_(std::move(file)),
      header_(read_las_header(file_, warnings_)),
      records_(read_las_records(file_, header_, warnings_)),
      layout_(read_layout(file_.name(), header_, records_)),
      info_(parse_copc_info(records_.copc_info->data, file_.name(), records_.copc_info->offset)),
      hierarchy_(read_copc_hierarchy(file_, info_, find_chunks(file_, header_, layout_, warnings_))) {}

void CopcFile::read_chunk(const CopcNode& node, std::vector<std::byte>& bytes) const {
  bytes.resize(static_cast<std::size_t>(node.chunk.byte_count));
  const std::lock_guard lock(mutex_);
  file_.read_at(node.chunk.offset, bytes);
}

Bounds CopcFile::bounds(const CopcNode& node) const {
  Bounds bounds = copc_cube(info_, node.key);
  const int levels_below = k_deepest_copc_level + 1 - node.key.level;
  for (int axis = 0; axis < 3; ++axis) {
    // A cube's faces are sums of three numbers, each rounded: a few units in the last offset of the largest.
    const double largest = std::abs(info_.centre[axis]) + 2 * info_.half_size;
    const double rounding = 8 * std::numeric_limits<double>::epsilon() * largest * levels_below;
    const double margin = header_.lattice.scale[axis] + rounding;
    bounds.min[axis] -= margin;
    bounds.max[axis] += margin;
  }
  return bounds;
}

PointCloud read_copc_nodes(std::span<const ChosenNodes> parts, const ReadOptions& options) {
  PointCloud cloud;
  JoinedProgress progress(options.progress, point_count(parts));
  std::vector<ColoredRows> colored;
  for (const ChosenNodes& part : parts) {
    const CopcFile& file = *part.file;
    if (&part == &parts.front()) {
      cloud.lattice = file.header().lattice;
      cloud.crs = file.records().crs;
    }
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
