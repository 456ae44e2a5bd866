// SPDX-License-Identifier: MIT
#include "visibility/lines/line_measure.h"

#include <nlohmann/json.hpp>

namespace alidade::visibility {

void put_position(const glm::dvec3& position, PartWriter& writer) {
  for (int axis = 0; axis < 3; ++axis) writer.put(position[axis]);
}

glm::dvec3 take_position(PartReader& reader) {
  glm::dvec3 position;
  for (int axis = 0; axis < 3; ++axis) position[axis] = reader.take<double>();
  return position;
}

std::uint64_t take_blocker_id(PartReader& reader, std::uint64_t point_count) {
  const auto id = reader.take<std::uint64_t>();
  reader.require(id < point_count || id == k_mesh_blocker);
  return id;
}

void put_point(const std::optional<LinePoint>& point, PartWriter& writer) {
  writer.put(std::uint8_t{point.has_value()});
  if (!point) return;
  writer.put(point->point_id);
  put_position(point->position, writer);
  writer.put(point->t);
  writer.put(point->distance);
}

std::optional<LinePoint> take_point(PartReader& reader, std::uint64_t point_count) {
  if (reader.take<std::uint8_t>() == 0) return {};
  LinePoint point;
  point.point_id = reader.take<std::uint64_t>();
  reader.require(point.point_id < point_count);
  point.position = take_position(reader);
  point.t = reader.take<double>();
  point.distance = reader.take<double>();
  return point;
}

Row id_value(std::uint64_t blocker_id) {
  return blocker_id == k_mesh_blocker ? Row() : Row(blocker_id);
}

Row class_value(std::span<const std::uint8_t> classes, std::uint64_t blocker_id) {
  if (classes.empty() || blocker_id == k_mesh_blocker) return nullptr;
  return classes[blocker_id];
}

void add_point(Row& row, const std::string& prefix, const std::optional<LinePoint>& point,
               std::span<const std::uint8_t> classes) {
  row[prefix + "_at"] = point ? Row(point->t) : Row();
  row[prefix + "_point"] = point ? Row(point->point_id) : Row();
  row[prefix + "_class"] = point ? class_value(classes, point->point_id) : Row();
}

}  // namespace alidade::visibility
