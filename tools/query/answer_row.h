// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "octree/query.h"

namespace alidade {

/// A row of the answer to any query. A family fills what it has.
struct AnswerRow {
  std::uint64_t target_id = 0;
  std::uint64_t rank = 0;  ///< among the target's answers, from 0
  std::uint64_t point_id = 0;
  glm::dvec3 position{0.0};
  std::uint64_t segment = 0;
  double t = 0.0, distance = 0.0, entry = 0.0;
  std::uint64_t count = 0;  ///< where only a number was asked for; of `occluded` 0 or 1
};

/// A column of the answer as text: its name and where its value stands.
struct AnswerColumn {
  std::string name;
  std::uint64_t AnswerRow::*whole = nullptr;  ///< one of these two, or else an axis of the position
  double AnswerRow::*real = nullptr;
  int axis = 0;
};

/// Rows of answers that are made when they are wanted, from several threads at once.
struct AnswerRows {
  std::size_t size = 0;
  /// Fills `rows` with the rows [first, first + rows.size()).
  std::function<void(std::size_t first, std::span<AnswerRow> rows)> fill;
};

/// Where answers go, in their order.
class AnswerOutput {
 public:
  virtual ~AnswerOutput() = default;
  /// Errors: no space, and other failures to write.
  virtual void write(const AnswerRows& rows) = 0;
  /// Ends the output; files appear under their name only here.
  virtual void finish() = 0;
};

/// Rows of an AnswerRows for which room is made at once: bounds memory whatever the number of answers.
constexpr std::size_t k_rows_at_once = 1 << 17;

}  // namespace alidade
