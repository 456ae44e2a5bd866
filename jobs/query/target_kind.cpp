// SPDX-License-Identifier: MIT
#include "jobs/query/target_kind.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

namespace alidade::jobs {
namespace {

constexpr double k_largest_number = 9007199254740992.0;  // 2^53: up to here doubles are exact

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

// In the order of TargetFamily.
constexpr TargetKind k_kinds[] = {
    {"ray", "rays", "ray_id", "Ray", k_ray_columns, k_ray_vectors, "--rays", "--ray",
     "rays: origin, direction of any length; they begin at the origin"},
    {"line", "lines", "ray_id", "Ray", k_ray_columns, k_ray_vectors, "--lines", "--line",
     "whole lines: as rays, but also behind the origin"},
    {"cone", "cones", "cone_id", "Cone", k_cone_columns, k_ray_vectors, "--cones", "--cone",
     "cones: apex, axis, half angle in degrees, radius at the apex (default 0)"},
    {"path", "paths", "path_id", "Path", k_path_columns, k_position_vectors, "--path", "--vertex",
     "trajectories: vertices in order; rows with one `path` number form one"},
    {"region", "regions", "region_id", "Region", k_plane_columns, k_plane_vectors, "--planes", "--plane",
     "regions: points on the positive side of all planes with one `region` number"},
    {"box", "boxes", "box_id", "Box", k_box_columns, k_box_vectors, "--boxes", "--box",
     "axis-aligned boxes, faces included"},
    {"point", "points", "query_id", "Query", k_point_columns, k_position_vectors, "--points", "--point",
     "positions"}};
static_assert(std::size(k_kinds) == k_target_families);

}  // namespace

std::size_t TargetKind::required_count() const {
  return static_cast<std::size_t>(std::ranges::count(columns, true, &TargetColumn::required));
}

std::string TargetKind::form() const {
  std::string text;
  for (const TargetColumn& column : columns)
    text += (column.required ? "" : "[") + std::string(text.empty() ? "" : ",").append(column.name) +
            (column.required ? "" : "]");
  return text;
}

std::string TargetKind::names() const {
  std::string text;
  for (const TargetColumn& known : columns) text += (text.empty() ? "" : ", ") + std::string(known.name);
  return text;
}

std::size_t TargetKind::column(std::string_view wanted) const {
  return static_cast<std::size_t>(std::ranges::find(columns, wanted, &TargetColumn::name) - columns.begin());
}

const TargetKind& target_kind(TargetFamily family) {
  return k_kinds[static_cast<std::size_t>(family)];
}

bool GivenTargets::can_be_reread() const {
  std::error_code error;
  return text != "-" && !std::filesystem::is_other(text, error);
}

const char* expected_value(ValueRule rule, double value) {
  switch (rule) {
    case ValueRule::coordinate:
      return std::isfinite(value) ? nullptr : "a finite number";
    case ValueRule::limit:
      return std::isnan(value) ? "a number, inf or -inf" : nullptr;
    case ValueRule::width:
      return std::isfinite(value) && value >= 0.0 ? nullptr : "a finite number, at least 0";
    case ValueRule::half_angle:
      return value >= 0.0 && value < 90.0 ? nullptr : "degrees, at least 0 and less than 90";
    case ValueRule::number:
      return value >= 0.0 && value <= k_largest_number && value == std::floor(value)
                 ? nullptr
                 : "an integer from 0 to 2^53";
  }
  return nullptr;
}

}  // namespace alidade::jobs
