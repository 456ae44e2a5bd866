// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "camera/camera.h"
#include "camera/formats/camera_file.h"

namespace alidade::camera {
namespace {

constexpr std::array<std::string_view, 12> k_columns{
    "time", "x", "y", "z", "qw", "qx", "qy", "qz", "look_at_x", "look_at_y", "look_at_z", "name"};
constexpr std::size_t k_time = 0, k_position = 1, k_quaternion = 4, k_target = 8, k_name = 11;
constexpr std::size_t k_not_there = std::size_t(-1);

/// Conventions that remarks above the table must give: axes are never guessed.
struct Conventions {
  std::optional<AxisConvention> axes;
  std::optional<bool> camera_to_world;
};

bool has_word(std::string_view line, std::string_view word) {
  for (FieldWalk fields(line); !fields.at_end();) {
    std::string_view each = fields.word("word");
    while (each.starts_with('#') || each.starts_with(':')) each.remove_prefix(1);
    if (each == word) return true;
  }
  return false;
}

void read_remark(std::string_view line, Conventions& conventions) {
  if (has_word(line, "opencv")) conventions.axes = AxisConvention::opencv;
  if (has_word(line, "opengl")) conventions.axes = AxisConvention::opengl;
  if (has_word(line, "camera_to_world")) conventions.camera_to_world = true;
  if (has_word(line, "world_to_camera")) conventions.camera_to_world = false;
}

using Columns = std::array<std::size_t, k_columns.size()>;

/// Whether the table has targets of the cameras instead of rotations.
bool has_targets(const Columns& columns) {
  return columns[k_target] != k_not_there;
}

Columns read_header(std::string_view line) {
  Columns columns;
  columns.fill(k_not_there);
  std::size_t index = 0;
  for (FieldWalk fields(line); !fields.at_end(); ++index) {
    const std::string_view word = fields.word("column");
    const auto known = std::ranges::find(k_columns, word);
    if (known == k_columns.end()) continue;  // further columns are ignored
    std::size_t& column = columns[static_cast<std::size_t>(known - k_columns.begin())];
    if (column != k_not_there)
      throw input_error(fmt::format("duplicate column '{}'", word), "unique columns");
    column = index;
  }
  const auto require = [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      if (columns[i] == k_not_there) {
        throw input_error(fmt::format("missing column '{}'", k_columns[i]),
                          "a header with time,x,y,z,qw,qx,qy,qz or x,y,z,look_at_x,look_at_y,look_at_z, and "
                          "optionally name, in any order");
      }
    }
  };
  if (has_targets(columns)) {
    require(k_position, k_quaternion);
    require(k_target, k_name);
  } else {
    require(k_time, k_target);
  }
  return columns;
}

/// `number`: of the row, from 0.
NamedCamera read_row(std::string_view line, std::size_t number, const Columns& columns,
                     const Conventions& conventions, const Camera& lens) {
  std::vector<std::string_view> row;
  for (FieldWalk fields(line); !fields.at_end();) row.push_back(fields.word("cell"));
  const auto cell = [&](std::size_t column) {
    if (columns[column] < row.size()) return row[columns[column]];
    throw input_error(fmt::format("missing value for '{}'", k_columns[column]), "one value per column",
                      fmt::format("{}", row.size()));
  };
  const auto vector_at = [&](std::size_t first) {
    glm::dvec3 vector;
    for (std::size_t i = 0; i < 3; ++i)
      vector[static_cast<int>(i)] = number_of(cell(first + i), std::string(k_columns[first + i]).c_str());
    if (!(std::fabs(vector.x) <= 1e12 && std::fabs(vector.y) <= 1e12 && std::fabs(vector.z) <= 1e12))
      throw input_error("position out of range", "coordinates within +-1e12");
    return vector;
  };
  const std::size_t named_by = columns[k_name] != k_not_there ? k_name : k_time;
  NamedCamera named{
      columns[named_by] == k_not_there ? fmt::format("{}", number) : std::string(cell(named_by)), lens};
  const glm::dvec3 position = vector_at(k_position);
  CameraPose& pose = named.camera.pose;
  if (has_targets(columns)) {
    pose = look_at(position, vector_at(k_target));
    return named;
  }
  std::array<double, 4> quaternion{};
  for (std::size_t i = 0; i < quaternion.size(); ++i)
    quaternion[i] = number_of(cell(k_quaternion + i), std::string(k_columns[k_quaternion + i]).c_str());
  const auto rotation = rotation_from_quaternion(quaternion);
  if (!rotation) throw Error({.problem = "the quaternion is zero"});
  number_of(cell(k_time), "time");
  if (*conventions.camera_to_world) {
    pose = {.position = position, .right = (*rotation)[0], .down = (*rotation)[1], .forward = (*rotation)[2]};
  } else {
    pose = pose_from_world_to_camera(*rotation, position);
  }
  if (conventions.axes == AxisConvention::opengl) {
    pose.down = -pose.down;
    pose.forward = -pose.forward;
  }
  return named;
}

}  // namespace

CameraSet read_trajectory(std::string_view text, const std::string& name, const std::optional<Camera>& lens) {
  CameraSet set;
  Conventions conventions;
  std::optional<Columns> columns;
  LineWalk lines(text);
  at_line(name, lines, [&] {
    for (std::string_view line; lines.next(line);) {
      if (lines.number() == 1 && line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
      const std::size_t first = line.find_first_not_of(" \t");
      if (first == std::string_view::npos) continue;
      if (line[first] == '#') {
        read_remark(line, conventions);
      } else if (!columns) {
        columns = read_header(line);
        if (!has_targets(*columns) && (!conventions.axes || !conventions.camera_to_world)) {
          throw input_error("missing convention of the quaternions",
                            "a line above the header such as '# opencv camera_to_world' (or opengl, "
                            "world_to_camera)");
        }
        if (!lens) {
          throw input_error("missing lens for the trajectory",
                            "--lens CAMERA.json, or a scene with a camera");
        }
      } else {
        set.cameras.push_back(read_row(line, set.cameras.size(), *columns, conventions, *lens));
      }
    }
  });
  return set;
}

}  // namespace alidade::camera
