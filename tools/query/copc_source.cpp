// SPDX-License-Identifier: MIT
#include "tools/query/copc_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/input_file.h"
#include "tools/interrupt.h"

namespace alidade {

bool asks_in_place(const QueryCommand& command, AnswerForm form) {
  if (command.files.size() != 1 || command.is_loaded || command.partial || command.max_level ||
      form == AnswerForm::las)
    return false;
  if (!std::filesystem::is_regular_file(command.files.front())) return false;
  InputFile file(command.files.front());
  return is_copc(file);
}

CopcSource open_copc(const QueryCommand& command) {
  CopcSource source;
  source.file = std::make_unique<CopcFile>(InputFile(command.files.front()));
  CopcCache::Options options;
  options.classes = command.classes;
  if (command.memory) options.byte_count = *command.memory;
  options.progress = [](std::uint64_t, std::uint64_t) { return !interrupted(); };
  source.cache = std::make_unique<CopcCache>(*source.file, options);
  return source;
}

std::string copc_table(const CopcCache& cache) {
  const auto& nodes = cache.file().hierarchy().nodes;
  const auto chunks = static_cast<std::uint64_t>(
      std::ranges::count_if(nodes, [](const CopcNode& node) { return node.chunk.point_count > 0; }));
  const std::uint64_t points = cache.file().header().point_count;
  const CopcReads reads = cache.reads();
  const auto share = [](std::uint64_t part, std::uint64_t all) {
    return all > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(all) : 0.0;
  };
  return fmt::format("{:<22}{:>16}{:>15.2f}%\n", "chunks read", reads.chunks_met,
                     share(reads.chunks_met, chunks)) +
         fmt::format("{:<22}{:>16}\n", "chunks decoded", reads.chunks_decoded) +
         fmt::format("{:<22}{:>16}{:>15.2f}%\n", "points decoded", reads.points_decoded,
                     share(reads.points_decoded, points));
}

}  // namespace alidade
