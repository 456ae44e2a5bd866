// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

// Options, common to several commands, that cannot change what they compute: how they run, what they print,
// and where they write.

namespace alidade::tools {

inline constexpr std::array<std::string_view, 6> k_silent_flags = {"help",  "overwrite", "skip-existing",
                                                                   "quiet", "verbose",   "resume"};

/// Options with a value.
inline constexpr std::array<std::string_view, 8> k_silent_options = {
    "output", "threads", "memory", "cache", "cache-size", "allow-host", "checkpoint", "checkpoint-interval"};

/// Whether the option of this name, without dashes, is one of these, or of those that a command adds to them.
inline bool is_silent(std::string_view name, std::span<const std::string_view> own) {
  const auto has = [name](std::span<const std::string_view> names) {
    return std::ranges::find(names, name) != names.end();
  };
  return has(k_silent_flags) || has(k_silent_options) || has(own);
}

}  // namespace alidade::tools
