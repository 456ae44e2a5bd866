// SPDX-License-Identifier: MIT
#include "tools/query/target_kind.h"

#include <algorithm>

namespace alidade {
namespace {

using enum ValueRule;

constexpr TargetColumn k_ray_columns[] = {
    {"ox"}, {"oy"}, {"oz"}, {"dx"}, {"dy"}, {"dz"}, {"t_min", limit, false}, {"t_max", limit, false}};
constexpr TargetColumn k_cone_columns[] = {{"ox"},
                                           {"oy"},
                                           {"oz"},
                                           {"dx"},
                                           {"dy"},
                                           {"dz"},
                                           {"half_angle", half_angle},
                                           {"radius", width, false},
                                           {"t_min", limit, false},
                                           {"t_max", limit, false}};
constexpr TargetVector k_ray_vectors[] = {{"origin", 0}, {"direction", 3, true}};

constexpr TargetColumn k_path_columns[] = {{"x"}, {"y"}, {"z"}, {"path", number, false}};
constexpr TargetColumn k_point_columns[] = {{"x"}, {"y"}, {"z"}};
constexpr TargetVector k_position_vectors[] = {{"position", 0}};

constexpr TargetColumn k_plane_columns[] = {
    {"px"}, {"py"}, {"pz"}, {"nx"}, {"ny"}, {"nz"}, {"region", number, false}};
constexpr TargetVector k_plane_vectors[] = {{"point", 0}, {"normal", 3, true}};

constexpr TargetColumn k_box_columns[] = {{"min_x", limit}, {"min_y", limit}, {"min_z", limit},
                                          {"max_x", limit}, {"max_y", limit}, {"max_z", limit}};
constexpr TargetVector k_box_vectors[] = {{"min", 0}, {"max", 3}};

constexpr TargetKind k_ray{"ray", "rays", "ray_id", "Ray", k_ray_columns, k_ray_vectors};
constexpr TargetKind k_cone{"cone", "cones", "cone_id", "Cone", k_cone_columns, k_ray_vectors};
constexpr TargetKind k_path{"path", "paths", "path_id", "Path", k_path_columns, k_position_vectors};
constexpr TargetKind k_region{"region", "regions", "region_id", "Region", k_plane_columns, k_plane_vectors};
constexpr TargetKind k_box{"box", "boxes", "box_id", "Box", k_box_columns, k_box_vectors};
constexpr TargetKind k_point{"point", "points", "query_id", "Query", k_point_columns, k_position_vectors};

}  // namespace

std::size_t TargetKind::required_count() const {
  return static_cast<std::size_t>(std::ranges::count(columns, true, &TargetColumn::required));
}

std::string TargetKind::form() const {
  std::string text;
  for (const TargetColumn& column : columns) {
    const char* const separator = text.empty() ? "" : ",";
    text.append(column.required ? "" : "[")
        .append(separator)
        .append(column.name)
        .append(column.required ? "" : "]");
  }
  return text;
}

std::string TargetKind::names() const {
  std::string text;
  for (const TargetColumn& known : columns) text += (text.empty() ? "" : ", ") + std::string(known.name);
  return text;
}

std::size_t TargetKind::column(std::string_view name_asked) const {
  return static_cast<std::size_t>(std::ranges::find(columns, name_asked, &TargetColumn::name) -
                                  columns.begin());
}

template <>
const TargetKind& target_kind<Ray>() {
  return k_ray;
}
template <>
const TargetKind& target_kind<Cone>() {
  return k_cone;
}
template <>
const TargetKind& target_kind<Path>() {
  return k_path;
}
template <>
const TargetKind& target_kind<HalfSpaces>() {
  return k_region;
}
template <>
const TargetKind& target_kind<Bounds>() {
  return k_box;
}
template <>
const TargetKind& target_kind<glm::dvec3>() {
  return k_point;
}

}  // namespace alidade
