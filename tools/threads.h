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

/// The number of threads that suits a command line, whose first word is the program's name; empty: as many as
/// the machine has. It is 8 per core if a command that queries rays is given an index file larger than
/// `memory` (bytes): most threads then wait for the disk, which serves many as fast as one.
std::optional<int> enough_threads(std::span<const std::string> words, std::uint64_t memory);

/// Returns what `work` returns, run on exactly this many threads.
ExitCode with_threads(std::optional<int> threads, const std::function<ExitCode()>& work);

}  // namespace alidade::tools
