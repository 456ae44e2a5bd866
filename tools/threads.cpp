// SPDX-License-Identifier: MIT
#include "tools/threads.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "base/words.h"

namespace alidade::tools {
namespace {

constexpr int k_most_threads = 1024;

}  // namespace

void add_threads(const Options& command, std::optional<int>& threads) {
  command.count("--threads", "N",
                "number of threads (default: all; 8 times as many where rays ask an index file larger than "
                "memory); results do not depend on it",
                threads, 1, k_most_threads);
}

std::optional<int> enough_threads(std::span<const std::string> words, std::uint64_t memory) {
  constexpr std::array<std::string_view, 4> k_ray_commands = {"render", "query", "visibility", "change"};
  if (words.size() < 2 || std::ranges::find(k_ray_commands, words[1]) == k_ray_commands.end())
    return std::nullopt;
  const bool waits = std::ranges::any_of(words, [&](const std::string& word) {
    std::error_code error;
    return has_extension(word, {".alidade"}) && std::filesystem::is_regular_file(word, error) &&
           std::filesystem::file_size(word, error) > memory;
  });
  constexpr int k_waiting_per_core = 8;
  if (!waits) return std::nullopt;
  return std::min(k_waiting_per_core * tbb::this_task_arena::max_concurrency(), k_most_threads);
}

ExitCode with_threads(std::optional<int> threads, const std::function<ExitCode()>& work) {
  if (!threads) return work();
  // The limit allows more threads than the machine has; the arena then requests them.
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(*threads));
  tbb::task_arena arena(*threads);
  return arena.execute(work);
}

}  // namespace alidade::tools
