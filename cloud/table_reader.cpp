// SPDX-License-Identifier: MIT
#include "cloud/table_reader.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "base/error.h"
#include "base/text_scanner.h"
#include "cloud/table_appender.h"

namespace alidade {

TableReader::TableReader(InputFile input, std::string format, Damage damage)
    : input_(std::move(input)), damage_(damage) {
  description_.path = input_.name();
  description_.format = std::move(format);
}

void TableReader::set_columns(std::vector<TableColumn> columns, const std::string& place) {
  std::unordered_set<std::string> names;
  for (const TableColumn& column : columns) {
    if (column.role == ColumnRole::ignored) continue;
    if (!names.insert(column.name).second)
      fail(place, "two columns have the same name", "names that differ", quote(column.name));
  }
  if (!find_role(columns, ColumnRole::x)) fail(place, "no x coordinate among the columns", "x, y and z");
  if (!find_role(columns, ColumnRole::y)) fail(place, "no y coordinate among the columns", "x, y and z");
  if (!find_role(columns, ColumnRole::z)) warn("has no z coordinate; it was taken as 0");
  columns_ = std::move(columns);
}

void TableReader::visit_whole_rows(const RowVisitor& visit, const Progress& progress) {
  lost_.clear();
  std::uint64_t rows = 0;
  bool is_visiting = false;
  try {
    visit_rows(
        [&](std::span<const Cell> row) {
          is_visiting = true;
          visit(row);
          is_visiting = false;
          ++rows;
        },
        progress);
  } catch (const Error& error) {
    if (is_visiting) throw;
    if (damage_ == Damage::refuse) throw DamagedFile(error.parts());
    const std::uint64_t announced = announced_rows().value_or(rows);
    lost_.push_back({.count = announced > rows ? announced - rows : 0,
                     .place = error.parts().place,
                     .problem = error.parts().problem});
  }
}

CoordinateSurvey TableReader::survey(const Progress& progress) {
  auto pass = std::make_unique<TableSurvey>(columns_);
  visit_whole_rows([&](std::span<const Cell> row) { pass->add(row); }, progress);
  survey_ = std::move(pass);
  return {.bounds = survey_->bounds(),
          .finite_count = survey_->finite_count(),
          .dropped_count = survey_->dropped_count(),
          .resolution = resolution(survey_->bounds())};
}

void TableReader::read_in_pieces(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                                 const Progress& progress) {
  if (!survey_) survey({});
  TableAppender appender(cloud, columns_, wanted, survey_->finite_count(), pieces);
  const auto assume = [&](Attribute attribute, const ValueScaling& scaling) {
    if (wanted.contains(attribute) && !scaling.assumption.empty() && survey_->finite_count() > 0)
      warn("it was assumed that " + scaling.assumption);
    return scaling;
  };
  if (find_role(columns_, ColumnRole::red))
    appender.scale_colors(
        assume(Attribute::color, color_scaling(type_of(ColumnRole::red), survey_->colors())));
  if (find_role(columns_, ColumnRole::near_infrared))
    appender.scale_near_infrared(color_scaling(type_of(ColumnRole::near_infrared), survey_->near_infrared()));
  if (find_role(columns_, ColumnRole::intensity))
    appender.scale_intensities(
        assume(Attribute::intensity,
               intensity_scaling(type_of(ColumnRole::intensity), survey_->intensities(), intensity_scale())));
  visit_whole_rows(
      [&](std::span<const Cell> row) {
        if (appender.add(row)) return;
        fail({}, "a point does not fit on the lattice, or the file changed while it was read");
      },
      progress);
  if (!appender.complete()) fail({}, "the file changed while it was read");

  description_.point_count = survey_->finite_count();
  description_.dropped_count = survey_->dropped_count();
  if (description_.dropped_count > 0)
    warn(std::to_string(description_.dropped_count) + " points " + reason_to_drop() + " were left out");
  cloud.warnings.insert(cloud.warnings.end(), warnings_.begin(), warnings_.end());
}

glm::dvec3 TableReader::resolution(const Bounds& bounds) const {
  glm::dvec3 result(0.0);
  if (bounds.empty()) return result;
  constexpr ColumnRole k_roles[] = {ColumnRole::x, ColumnRole::y, ColumnRole::z};
  for (int axis = 0; axis < 3; ++axis) {
    if (!find_role(columns_, k_roles[axis])) continue;
    const double largest = std::max(std::abs(bounds.min[axis]), std::abs(bounds.max[axis]));
    result[axis] = type_resolution(type_of(k_roles[axis]), largest);
  }
  return result;
}

ScalarType TableReader::type_of(ColumnRole role) const {
  return columns_[find_role(columns_, role).value()].type;
}

void TableReader::warn(const std::string& clause) {
  warnings_.push_back(input_.name() + ": " + clause);
}

void TableReader::fail(std::string place, std::string problem, std::string expected,
                       std::string found) const {
  throw Error({.file = input_.name(),
               .place = std::move(place),
               .problem = std::move(problem),
               .expected = std::move(expected),
               .found = std::move(found)});
}

}  // namespace alidade
