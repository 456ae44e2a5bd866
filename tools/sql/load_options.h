// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>

#include "cloud/read_cloud.h"
#include "tools/options.h"

namespace alidade {

/// What commands have in common that put clouds into databases, which memory need not hold.
struct LoadOptions {
  bool partial = false;
  std::optional<ColorDepth> color_depth;
  std::uint64_t memory = std::uint64_t{1} << 30;
  std::optional<int> threads;
  VerbosityOptions verbosity;
};

/// Declares them.
void add_load_options(CLI::App& command, LoadOptions& options);

/// Does `work`, which reads files and then stores points, with a progress line for each; prints the warnings
/// that it answers. `storing` is what the second line says.
void load_with_progress(
    const LoadOptions& options, const std::string& storing,
    const std::function<std::vector<std::string>(const ReadOptions& reading, const Progress& storing)>& work);

}  // namespace alidade
