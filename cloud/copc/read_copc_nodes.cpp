// SPDX-License-Identifier: MIT
#include "cloud/copc/read_copc_nodes.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <optional>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "cloud/append_rows.h"
#include "cloud/fit_lattice.h"
#include "cloud/las/read_las.h"
#include "cloud/laz/attribute_layers.h"
#include "cloud/laz/chunk_codec.h"
#include "cloud/laz/corrupt_chunk.h"
#include "cloud/spread_colors.h"

namespace alidade {
namespace {

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
  std::vector<std::optional<CorruptChunk>> problems(part.nodes.size());
  tbb::parallel_for(std::size_t{0}, part.nodes.size(), [&](std::size_t i) {
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
      // Which one is told must not depend on threads.
      problems[i] = problem;
    }
    progress.add(node.chunk.point_count);
  });
  for (std::size_t i = 0; i < problems.size(); ++i) {
    if (!problems[i]) continue;
    throw Error({.file = file.name(),
                 .place = fmt::format("COPC node {}", file.hierarchy().nodes[part.nodes[i]].key.name()),
                 .problem = fmt::format("the compressed points are damaged: {}", problems[i]->what())});
  }
}

}  // namespace

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
    const std::optional<glm::i64vec3> shift = steps_between(file.header().lattice, cloud.lattice);
    if (!shift)
      throw Error({.file = file.name(), .problem = "does not share the lattice of the files before it"});
    const LasColumns columns(file.name(), file.header(), file.records().extra_dimensions);
    const LasColumns::Choice choice = columns.choose(options.attributes, *shift, cloud);
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
