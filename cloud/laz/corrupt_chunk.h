// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

namespace alidade {

/// What a LAZ decoder throws when a chunk cannot have been written by any encoder. It knows neither file nor
/// place: whoever reads the file turns it into an Error that names file, chunk and point.
struct CorruptChunk : std::runtime_error {
  /// `problem` is one clause in lower case, without full stop; `point` counts from 0 within the chunk and is
  /// empty if no point is concerned.
  explicit CorruptChunk(const std::string& problem, std::optional<std::uint64_t> in_point = std::nullopt)
      : std::runtime_error(problem), point(in_point) {}

  std::optional<std::uint64_t> point;
};

}  // namespace alidade
