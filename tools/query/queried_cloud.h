// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "base/bounds.h"
#include "tools/query/answer_row.h"
#include "tools/query/query.h"

namespace alidade {

/// A box outside which no point answers, from a first look through the targets and at the headers of the
/// files; empty if there is none to be had: of one file, of half-spaces, without a radius, for targets that
/// come through a pipe or are more than a million, and where the answer also depends on points that are not
/// in it (levels, colours in LAS). Errors: those of targets, and of opening files.
template <class Target>
std::optional<Bounds> query_region(const QueryCommand& command, TargetFamily family, AnswerForm form);

extern template std::optional<Bounds> query_region<Ray>(const QueryCommand&, TargetFamily, AnswerForm);
extern template std::optional<Bounds> query_region<Cone>(const QueryCommand&, TargetFamily, AnswerForm);
extern template std::optional<Bounds> query_region<Path>(const QueryCommand&, TargetFamily, AnswerForm);
extern template std::optional<Bounds> query_region<HalfSpaces>(const QueryCommand&, TargetFamily, AnswerForm);
extern template std::optional<Bounds> query_region<Bounds>(const QueryCommand&, TargetFamily, AnswerForm);
extern template std::optional<Bounds> query_region<glm::dvec3>(const QueryCommand&, TargetFamily, AnswerForm);

/// More targets than these are not looked through before they are asked.
inline constexpr std::uint64_t k_most_looked_through = 1'000'000;

/// Whether targets can be looked through before they are asked.
bool can_be_read_twice(const GivenTargets& given);

/// Answers whose points are numbered in another way, in the same order.
class RenumberedAnswers final : public AnswerOutput {
 public:
  using Ids = std::function<std::uint64_t(std::uint64_t row)>;

  RenumberedAnswers(std::unique_ptr<AnswerOutput> output, Ids ids)
      : output_(std::move(output)), ids_(std::move(ids)) {}

  void write(const AnswerRows& rows) override;
  void finish() override { output_->finish(); }

 private:
  std::unique_ptr<AnswerOutput> output_;
  Ids ids_;
};

}  // namespace alidade
