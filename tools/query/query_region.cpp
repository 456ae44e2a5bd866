// SPDX-License-Identifier: MIT
#include "tools/query/queried_cloud.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "cloud/read_cloud.h"
#include "tools/query/target_bounds.h"
#include "tools/query/target_reader.h"

namespace alidade {
namespace {

constexpr std::size_t k_batch = 4096;

bool contains(const Bounds& outer, const Bounds& inner) {
  return outer.contains(inner.min) && outer.contains(inner.max);
}

}  // namespace

bool can_be_read_twice(const GivenTargets& given) {
  std::error_code error;
  return given.text.empty() || std::filesystem::is_regular_file(given.text, error);
}

template <class Target>
std::optional<Bounds> query_region(const QueryCommand& command, TargetFamily family, AnswerForm form) {
  constexpr bool needs_radius =
      std::is_same_v<Target, Ray> || std::is_same_v<Target, Path> || std::is_same_v<Target, glm::dvec3>;
  const bool is_bounded = needs_radius ? command.radius.has_value() : !std::is_same_v<Target, HalfSpaces>;
  if (command.files.size() < 2 || !is_bounded || command.partial || command.max_level ||
      form == AnswerForm::las || !can_be_read_twice(command.targets[static_cast<std::size_t>(family)]))
    return std::nullopt;
  const Bounds within = stated_box(command.files);
  TargetReader<Target> reader(open_targets(command, family), {command.t_min, command.t_max});
  TargetBatch<Target> batch;
  Bounds region;
  for (std::uint64_t count = 0; reader.next(k_batch, batch); count += batch.targets.size()) {
    if (count > k_most_looked_through) return std::nullopt;
    for (const Target& target : batch.targets)
      region.grow(target_bounds(target, command.radius.value_or(0.0), within));
    if (contains(region, within)) return std::nullopt;
  }
  return region;
}

template std::optional<Bounds> query_region<Ray>(const QueryCommand&, TargetFamily, AnswerForm);
template std::optional<Bounds> query_region<Cone>(const QueryCommand&, TargetFamily, AnswerForm);
template std::optional<Bounds> query_region<Path>(const QueryCommand&, TargetFamily, AnswerForm);
template std::optional<Bounds> query_region<HalfSpaces>(const QueryCommand&, TargetFamily, AnswerForm);
template std::optional<Bounds> query_region<Bounds>(const QueryCommand&, TargetFamily, AnswerForm);
template std::optional<Bounds> query_region<glm::dvec3>(const QueryCommand&, TargetFamily, AnswerForm);

void RenumberedAnswers::write(const AnswerRows& rows) {
  output_->write({rows.size, [this, &rows](std::size_t first, std::span<AnswerRow> some) {
                    rows.fill(first, some);
                    for (AnswerRow& row : some) row.point_id = ids_(row.point_id);
                  }});
}

}  // namespace alidade
