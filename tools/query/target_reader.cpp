// SPDX-License-Identifier: MIT
#include "tools/query/target_reader.h"

#include <fmt/format.h>
#include <cmath>
#include <limits>

namespace alidade::tools {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();

template <class Target>
constexpr bool is_group = std::is_same_v<Target, Path> || std::is_same_v<Target, HalfSpaces>;

glm::dvec3 vector_at(std::span<const double> row, std::size_t first) {
  return {row[first], row[first + 1], row[first + 2]};
}

/// A value that was given, else the option's, else the usual one.
double value_or(double given, const std::optional<double>& option, double usual) {
  return std::isnan(given) ? option.value_or(usual) : given;
}

template <class Target>
Target made(std::span<const double> row, const DefaultInterval& interval) {
  if constexpr (std::is_same_v<Target, Ray>) {
    return make_ray(vector_at(row, 0), vector_at(row, 3), value_or(row[6], interval.t_min, -k_infinity),
                    value_or(row[7], interval.t_max, k_infinity));
  } else if constexpr (std::is_same_v<Target, Cone>) {
    const double half_angle = row[6] * (std::acos(-1.0) / 180.0);
    return make_cone(vector_at(row, 0), vector_at(row, 3), half_angle, value_or(row[7], {}, 0.0),
                     value_or(row[8], interval.t_min, 0.0), value_or(row[9], interval.t_max, k_infinity));
  } else if constexpr (std::is_same_v<Target, Bounds>) {
    return {vector_at(row, 0), vector_at(row, 3)};
  } else {
    return vector_at(row, 0);
  }
}

}  // namespace

template <class Target>
bool TargetReader<Target>::next(std::size_t most, TargetBatch<Target>& batch) {
  batch.targets.clear();
  batch.ids.clear();
  while (batch.targets.size() < most) {
    if (used_ < block_.size()) {
      take_row(used_++, batch);
    } else if (rows_.next(block_)) {
      used_ = 0;
    } else {
      end_group(batch);
      break;
    }
  }
  return !batch.targets.empty();
}

template <class Target>
double TargetReader<Target>::share() const {
  const std::size_t size = block_.size();
  return rows_.share(size == 0 ? 1.0 : static_cast<double>(used_) / static_cast<double>(size));
}

template <class Target>
template <class Make>
auto TargetReader<Target>::at_line(std::uint64_t line, const Make& make) const {
  try {
    return make();
  } catch (const Error& error) {
    const Error::Parts& parts = error.parts();
    rows_.fail(line, parts.problem, parts.expected, parts.found);
  }
}

template <class Target>
void TargetReader<Target>::take_row(std::size_t i, TargetBatch<Target>& batch) {
  const std::span<const double> row = block_.row(i);
  if constexpr (is_group<Target>) {
    const double number = row.back();
    const std::uint64_t group = std::isnan(number) ? 0 : static_cast<std::uint64_t>(number);
    if (group_ && group < *group_) {
      rows_.fail(block_.lines[i],
                 fmt::format("{} numbers are not in ascending order", target_kind<Target>().name),
                 "rows sorted by number", fmt::format("{}", group));
    }
    if (group_ != group) {
      end_group(batch);
      group_ = group;
      group_line_ = block_.lines[i];
    }
    if constexpr (std::is_same_v<Target, Path>) {
      vertices_.push_back(vector_at(row, 0));
    } else {
      planes_.push_back(
          at_line(block_.lines[i], [&] { return make_plane(vector_at(row, 0), vector_at(row, 3)); }));
    }
  } else {
    batch.targets.push_back(at_line(block_.lines[i], [&] { return made<Target>(row, interval_); }));
    batch.ids.push_back(next_id_++);
  }
}

template <class Target>
void TargetReader<Target>::end_group(TargetBatch<Target>& batch) {
  if constexpr (is_group<Target>) {
    if (!group_) return;
    if constexpr (std::is_same_v<Target, Path>) {
      batch.targets.push_back(at_line(group_line_, [&] {
        return make_path(vertices_, interval_.t_min.value_or(-k_infinity),
                         interval_.t_max.value_or(k_infinity));
      }));
      vertices_.clear();
    } else {
      batch.targets.push_back({std::move(planes_)});
      planes_.clear();
    }
    batch.ids.push_back(*group_);
    group_.reset();
  }
}

template class TargetReader<Ray>;
template class TargetReader<Cone>;
template class TargetReader<Path>;
template class TargetReader<HalfSpaces>;
template class TargetReader<Bounds>;
template class TargetReader<glm::dvec3>;

}  // namespace alidade::tools
