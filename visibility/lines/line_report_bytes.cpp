// SPDX-License-Identifier: MIT
#include "visibility/lines/line_report_bytes.h"

namespace alidade {
namespace {

constexpr std::size_t k_obstruction_bytes = 16;

void put_place(const glm::dvec3& place, PartWriter& writer) {
  for (int axis = 0; axis < 3; ++axis) writer.put(place[axis]);
}

void put_point(const std::optional<LinePoint>& point, PartWriter& writer) {
  writer.put(std::uint8_t{point.has_value()});
  if (!point) return;
  writer.put(point->point_id);
  put_place(point->position, writer);
  writer.put(point->t);
  writer.put(point->distance);
}

void put_fresnel(const FresnelClearance& zone, PartWriter& writer) {
  for (const double number :
       {zone.radius, zone.obstructed, zone.worst, zone.worst_t, zone.cut_off, zone.inner, zone.nearest_share})
    writer.put(number);
  writer.put(std::uint8_t{zone.is_clear});
  put_point(zone.nearest, writer);
  writer.put(zone.points);
  writer.put(std::uint64_t{zone.obstructions.size()});
  for (const Obstruction& one : zone.obstructions) {
    writer.put(one.point_id);
    writer.put(one.share);
  }
}

class ReportReader {
 public:
  ReportReader(PartReader& reader, std::uint64_t point_count) : reader_(reader), point_count_(point_count) {}

  bool take_flag() { return reader_.take<std::uint8_t>() != 0; }
  double take_number() { return reader_.take<double>(); }
  std::uint64_t take_id() {
    const auto id = reader_.take<std::uint64_t>();
    reader_.require(id < point_count_);
    return id;
  }
  glm::dvec3 take_place() {
    glm::dvec3 place{0.0};
    for (int axis = 0; axis < 3; ++axis) place[axis] = take_number();
    return place;
  }
  std::optional<LinePoint> take_point() {
    if (!take_flag()) return std::nullopt;
    LinePoint point;
    point.point_id = take_id();
    point.position = take_place();
    point.t = take_number();
    point.distance = take_number();
    return point;
  }
  FresnelClearance take_fresnel() {
    FresnelClearance zone;
    for (double* const number : {&zone.radius, &zone.obstructed, &zone.worst, &zone.worst_t, &zone.cut_off,
                                 &zone.inner, &zone.nearest_share})
      *number = take_number();
    zone.is_clear = take_flag();
    zone.nearest = take_point();
    zone.points = reader_.take<std::uint64_t>();
    zone.obstructions.resize(reader_.take_count(k_obstruction_bytes));
    for (Obstruction& one : zone.obstructions) {
      one.point_id = take_id();
      one.share = take_number();
    }
    return zone;
  }

 private:
  PartReader& reader_;
  std::uint64_t point_count_;
};

}  // namespace

void put_report(const LineReport& report, PartWriter& writer) {
  writer.put(report.length);
  writer.put(std::uint8_t{report.blocker.has_value()});
  if (report.blocker) {
    writer.put(report.blocker->point_id);
    put_place(report.blocker->position, writer);
    writer.put(report.blocker->distance);
  }
  put_point(report.nearest, writer);
  writer.put(std::uint8_t{report.fresnel.has_value()});
  if (report.fresnel) put_fresnel(*report.fresnel, writer);
}

LineReport take_report(PartReader& reader, std::uint64_t point_count) {
  ReportReader from(reader, point_count);
  LineReport report;
  report.length = from.take_number();
  if (from.take_flag()) {
    Blocker& blocker = report.blocker.emplace();
    blocker.point_id = from.take_id();
    blocker.position = from.take_place();
    blocker.distance = from.take_number();
  }
  report.nearest = from.take_point();
  if (from.take_flag()) report.fresnel = from.take_fresnel();
  return report;
}

}  // namespace alidade
