// SPDX-License-Identifier: MIT
#include "simulation/beams.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace alidade {

StationBeams::StationBeams(const TerrestrialScanner& scanner, double steps_per_degree) : scanner_(scanner) {
  const double height = scanner.elevation_max - scanner.elevation_min;
  columns_ = static_cast<std::uint64_t>(std::max(1.0, std::floor(360.0 * steps_per_degree + 0.5)));
  rows_.resize(static_cast<std::size_t>(std::max(1.0, std::floor(height * steps_per_degree + 0.5))));
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const double share = (static_cast<double>(row) + 0.5) / static_cast<double>(rows_.size());
    rows_[row] = sine_cosine(radians(scanner.elevation_min + height * share));
  }
}

Beam StationBeams::beam(const Station& station, std::uint64_t index) const {
  const std::uint64_t column = index / rows_.size(), row = index % rows_.size();
  const SineCosine azimuth =
      sine_cosine(radians(360.0) * ((static_cast<double>(column) + 0.5) / static_cast<double>(columns_)));
  const SineCosine& elevation = rows_[row];
  const double share = (static_cast<double>(row) + 0.5) / static_cast<double>(rows_.size());
  const double degrees_from_nadir =
      90.0 + scanner_.elevation_min + (scanner_.elevation_max - scanner_.elevation_min) * share;
  const glm::dvec3 direction(azimuth.sine * elevation.cosine, azimuth.cosine * elevation.cosine,
                             elevation.sine);
  return {make_ray(station.position, direction, scanner_.range_min, scanner_.range_max),
          static_cast<float>(degrees_from_nadir),
          scanner_.seconds * ((static_cast<double>(index) + 0.5) / static_cast<double>(count()))};
}

FlightBeams::FlightBeams(const DroneScanner& scanner, const std::vector<FlightLine>& lines,
                         double ground_height, std::uint64_t count, int pass)
    : scanner_(scanner), count_(count) {
  constexpr double k_golden = 0.6180339887498949;  // multiples of it never come close to each other
  constexpr double k_turn_seconds = 12.0;
  shift_ = k_golden * pass;
  if (lines.empty()) throw Error({.problem = "a scan needs at least one flight line"});
  std::vector<double> areas;
  double area_sum = 0.0;
  for (const FlightLine& line : lines) {
    if (!(line.pitch > -80.0 && line.pitch < 80.0))
      throw Error({.problem = "pitch of a flight line is out of (-80, 80) degrees"});
    if (!(line.field_of_view > 0.0 && line.field_of_view < 160.0))
      throw Error({.problem = "field of view of a flight line is out of (0, 160) degrees"});
    const double height = line.start.z - ground_height;
    if (!(height > 0.0) || line.end.z != line.start.z)
      throw Error({.problem = "flight line is not level above the ground"});
    Strip strip{.line = line, .seconds_begin = seconds_};
    const glm::dvec3 run = line.end - line.start;
    strip.length = glm::length(run);
    if (!(strip.length > 0.0)) throw Error({.problem = "flight line has no length"});
    strip.ahead = run / strip.length;
    strip.side = {strip.ahead.y, -strip.ahead.x, 0.0};
    const SineCosine pitch = sine_cosine(radians(line.pitch)),
                     half = sine_cosine(radians(0.5 * line.field_of_view));
    strip.down = pitch.sine * strip.ahead - glm::dvec3(0.0, 0.0, pitch.cosine);
    const double swath = 2.0 * height / pitch.cosine * (half.sine / half.cosine);
    strip.sweeps = swath;
    areas.push_back(strip.length * swath);
    area_sum += areas.back();
    seconds_ += strip.length / scanner.speed + k_turn_seconds;
    strips_.push_back(strip);
  }
  double area_before = 0.0;
  std::uint64_t begin = 0;
  for (std::size_t i = 0; i < strips_.size(); ++i) {
    area_before += areas[i];
    const bool last = i + 1 == strips_.size();
    const auto end = last ? count
                          : std::min(count, static_cast<std::uint64_t>(static_cast<double>(count) *
                                                                       (area_before / area_sum)));
    Strip& strip = strips_[i];
    strip.begin = begin;
    strip.count = end - begin;
    // Sweeps as far apart as their beams: length / sweeps = swath / (count / sweeps).
    const double swath = strip.sweeps;
    strip.sweeps =
        std::max(1.0, std::floor(std::sqrt(strip.length / swath * static_cast<double>(strip.count)) + 0.5));
    begin = end;
  }
}

std::size_t FlightBeams::line_of(std::uint64_t index) const {
  const auto after = std::upper_bound(
      strips_.begin(), strips_.end(), index,
      [](std::uint64_t beam, const Strip& strip) { return beam < strip.begin + strip.count; });
  return static_cast<std::size_t>(after - strips_.begin());
}

Beam FlightBeams::beam(std::uint64_t index) const {
  const Strip& strip = strips_[line_of(index)];
  const double share = (static_cast<double>(index - strip.begin) + 0.5) / static_cast<double>(strip.count);
  const double sweeps = share * strip.sweeps + shift_;
  const double degrees = strip.line.field_of_view * (sweeps - std::floor(sweeps) - 0.5);
  const SineCosine across = sine_cosine(radians(degrees));
  const glm::dvec3 origin = strip.line.start + share * strip.length * strip.ahead;
  return {make_ray(origin, across.cosine * strip.down + across.sine * strip.side, 0.0, scanner_.range_max),
          static_cast<float>(degrees), strip.seconds_begin + share * strip.length / scanner_.speed};
}

}  // namespace alidade
