// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "tools/console.h"
#include "tools/options.h"

namespace alidade::tools {

/// --threads N; empty = as many as the machine has, or enough_threads().
void add_threads(const Options& command, std::optional<int>& threads);

/// How many threads serve a command of these words best, the program's name included, if not as many as the machine
/// has: 8 a core where rays ask an index file among the words that is larger than `memory`, in bytes. Then most threads
/// wait for the disk, which answers many as fast as one.
std::optional<int> enough_threads(std::span<const std::string> words, std::uint64_t memory);

/// What `work` answers, run on exactly this many threads.
ExitCode with_threads(std::optional<int> threads, const std::function<ExitCode()>& work);

}  // namespace alidade::tools
