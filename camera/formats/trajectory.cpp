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

constexpr std::array<std::string_view, 9> k_columns{"time", "x", "y", "z", "qw", "qx", "qy", "qz", "name"};
constexpr std::size_t k_name = 8;
constexpr std::size_t k_not_there = std::size_t(-1);

/// What the remarks above the table must say: nothing about axes is guessed.
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

Columns read_header(std::string_view line) {
  Columns columns;
  columns.fill(k_not_there);
  std::size_t position = 0;
  for (FieldWalk fields(line); !fields.at_end(); ++position) {
    const std::string_view word = fields.word("column");
    const auto known = std::ranges::find(k_columns, word);
    if (known == k_columns.end()) continue;  // further columns are the user's
    std::size_t& column = columns[static_cast<std::size_t>(known - k_columns.begin())];
    if (column != k_not_there)
      throw input_error(fmt::format("duplicate column '{}'", word), "unique columns");
    column = position;
  }
  for (std::size_t i = 0; i < k_name; ++i) {
    if (columns[i] == k_not_there) {
      throw input_error(fmt::format("missing column '{}'", k_columns[i]),
                        "a header with time,x,y,z,qw,qx,qy,qz and optionally name, in any order");
    }
  }
  return columns;
}

NamedCamera read_row(std::string_view line, const Columns& columns, const Conventions& conventions,
                     const Camera& lens) {
  std::vector<std::string_view> row;
  for (FieldWalk fields(line); !fields.at_end();) row.push_back(fields.word("cell"));
  const auto cell = [&](std::size_t column) {
    if (columns[column] < row.size()) return row[columns[column]];
    throw input_error(fmt::format("missing value for '{}'", k_columns[column]), "one value per column",
                      fmt::format("{}", row.size()));
  };
  std::array<double, 8> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i)
    numbers[i] = number_of(cell(i), std::string(k_columns[i]).c_str());
  const auto rotation = rotation_from_quaternion({numbers[4], numbers[5], numbers[6], numbers[7]});
  if (!rotation) throw Error({.problem = "the quaternion is zero"});
  const glm::dvec3 position(numbers[1], numbers[2], numbers[3]);
  if (!(std::fabs(position.x) <= 1e12 && std::fabs(position.y) <= 1e12 && std::fabs(position.z) <= 1e12))
    throw input_error("position out of range", "coordinates within +-1e12");

  NamedCamera named{std::string(columns[k_name] == k_not_there ? cell(0) : cell(k_name)), lens};
  CameraPose& pose = named.camera.pose;
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
        if (!conventions.axes || !conventions.camera_to_world) {
          throw input_error("missing convention of the quaternions",
                            "a line above the header such as '# opencv camera_to_world' (or opengl, "
                            "world_to_camera)");
        }
        if (!lens) {
          throw input_error("missing lens for the trajectory",
                            "--lens CAMERA.json, or a scene with a camera");
        }
      } else {
        set.cameras.push_back(read_row(line, *columns, conventions, *lens));
      }
    }
  });
  return set;
}

}  // namespace alidade::camera
