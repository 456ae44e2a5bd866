// SPDX-License-Identifier: MIT
#include "visibility/lines/line_row.h"

#include <algorithm>
#include <array>

namespace alidade {
namespace {

Row class_of(const LineTable& table, std::uint64_t point_id) {
  if (table.classifications.empty()) return nullptr;
  return table.classifications[point_id];
}

/// A class and its share of a zone.
struct ClassShare {
  int number;
  double share;
};

/// The largest first, then by number; empty for a cloud without classes.
std::vector<ClassShare> class_shares(const LineTable& table, const FresnelClearance& fresnel) {
  std::array<double, 256> shares{};
  if (!table.classifications.empty()) {
    for (const Obstruction& one : fresnel.obstructions)
      shares[table.classifications[one.point_id]] += one.share;
  }
  std::vector<ClassShare> classes;
  for (int number = 0; number < 256; ++number) {
    const double share = shares[static_cast<std::size_t>(number)];
    if (share > 0.0) classes.push_back({number, share});
  }
  std::ranges::stable_sort(classes, std::greater(), &ClassShare::share);
  return classes;
}

void add_place(Row& row, const std::string& name, const glm::dvec3& place) {
  row[name + "_x"] = place.x;
  row[name + "_y"] = place.y;
  row[name + "_z"] = place.z;
}

/// Names `prefix` + at, point, class.
void add_point(Row& row, const LineTable& table, const std::string& prefix,
               const std::optional<LinePoint>& point) {
  row[prefix + "_at"] = point ? Row(point->t) : Row();
  row[prefix + "_point"] = point ? Row(point->point_id) : Row();
  row[prefix + "_class"] = point ? class_of(table, point->point_id) : Row();
}

void add_fresnel(Row& row, const LineTable& table, const FresnelClearance& fresnel) {
  row["fresnel_radius"] = fresnel.radius;
  row["fresnel_clear"] = fresnel.is_clear;
  row["fresnel_obstructed"] = fresnel.obstructed;
  row["fresnel_inner"] = fresnel.inner;
  row["fresnel_worst"] = fresnel.worst;
  row["fresnel_worst_at"] = fresnel.obstructions.empty() ? Row() : Row(fresnel.worst_t);
  row["fresnel_cut_off"] = fresnel.cut_off;
  const std::vector<ClassShare> classes = class_shares(table, fresnel);
  row["fresnel_class"] = classes.empty() ? Row() : Row(classes.front().number);
  row["fresnel_class_share"] = classes.empty() ? Row() : Row(classes.front().share);
  row["fresnel_points"] = fresnel.points;
  row["fresnel_nearest"] = fresnel.nearest ? Row(fresnel.nearest_share) : Row();
  add_point(row, table, "fresnel_nearest", fresnel.nearest);
}

}  // namespace

Row line_row(const LineTable& table, std::size_t line) {
  const LinePair& pair = table.pairs[line];
  const LineReport& report = table.reports[line];
  Row row;
  row["line"] = line;
  row["from"] = pair.from_name;
  row["to"] = pair.to_name;
  add_place(row, "from", pair.from.position);
  add_place(row, "to", pair.to.position);
  row["length"] = report.length;
  row["visible"] = !report.blocker;
  const std::optional<Blocker>& blocker = report.blocker;
  row["blocker"] = blocker ? Row(blocker->point_id) : Row();
  row["blocker_class"] = blocker ? class_of(table, blocker->point_id) : Row();
  row["blocker_at"] = blocker ? Row(blocker->distance) : Row();
  for (int axis = 0; axis < 3; ++axis)
    row[std::string("blocker_") + "xyz"[axis]] = blocker ? Row(blocker->position[axis]) : Row();
  row["clearance"] = report.nearest ? Row(report.nearest->distance) : Row();
  add_point(row, table, "clearance", report.nearest);
  if (report.fresnel) add_fresnel(row, table, *report.fresnel);
  return row;
}

Row line_obstructions(const LineTable& table, std::size_t line) {
  const std::optional<FresnelClearance>& fresnel = table.reports[line].fresnel;
  Row points = Row::array(), classes = Row::array();
  if (fresnel) {
    for (const Obstruction& one : fresnel->obstructions)
      points.push_back(
          {{"point", one.point_id}, {"class", class_of(table, one.point_id)}, {"share", one.share}});
    for (const ClassShare& one : class_shares(table, *fresnel))
      classes.push_back({{"class", one.number}, {"share", one.share}});
  }
  return {{"points", points}, {"classes", classes}};
}

}  // namespace alidade
