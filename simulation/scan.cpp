// SPDX-License-Identifier: MIT
#include "simulation/scan.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/parallel_reduce.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>
#include <utility>

#include "base/exact_math.h"
#include "base/ray.h"
#include "simulation/noise.h"

namespace alidade::simulation {
namespace {

constexpr double radians(double degrees) {
  return degrees * (std::numbers::pi / 180.0);
}

// The beams of a scan: beam number -> ray, without regard to the site.

/// One emitted beam.
struct Beam {
  Ray ray;                  ///< world, within the scanner's range
  float scan_angle = 0.0f;  ///< degrees from straight down, as in LAS
  double seconds = 0.0;     ///< since the scan or flight began
};

/// The raster of a terrestrial scanner. Beam = column * rows + row; columns follow
/// azimuth, rows elevation upwards.
class StationBeams {
 public:
  /// About `steps_per_degree` in both directions; at least one row and column.
  StationBeams(const TerrestrialScanner& scanner, double steps_per_degree) : scanner_(scanner) {
    const double height = scanner.elevation_max - scanner.elevation_min;
    columns_ = static_cast<std::uint64_t>(std::max(1.0, std::floor(360.0 * steps_per_degree + 0.5)));
    rows_.resize(static_cast<std::size_t>(std::max(1.0, std::floor(height * steps_per_degree + 0.5))));
    for (std::size_t row = 0; row < rows_.size(); ++row) {
      const double share = (static_cast<double>(row) + 0.5) / static_cast<double>(rows_.size());
      rows_[row] = sine_cosine_by_quarters(radians(scanner.elevation_min + height * share));
    }
  }

  std::uint64_t count() const { return columns_ * rows_.size(); }

  Beam beam(const Station& station, std::uint64_t index) const {
    const std::uint64_t column = index / rows_.size(), row = index % rows_.size();
    const SineCosine azimuth = sine_cosine_by_quarters(
        radians(360.0) * ((static_cast<double>(column) + 0.5) / static_cast<double>(columns_)));
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

 private:
  TerrestrialScanner scanner_;
  std::uint64_t columns_ = 1;
  std::vector<SineCosine> rows_;  ///< of the elevation of each row
};

/// `count` beams spread evenly over flight lines: a number on each in proportion to the area of its strip, in
/// sweeps as far apart as the beams of a sweep.
class FlightBeams {
 public:
  /// `ground_height` is the level on which the strips are measured; `pass` shifts the sweeps so that those of
  /// a second pass are between those of the first. Errors: a line without length; a line not above the
  /// ground; pitch or field of view out of range.
  FlightBeams(const DroneScanner& scanner, const std::vector<FlightLine>& lines, double ground_height,
              std::uint64_t count, int pass)
      : scanner_(scanner), count_(count) {
    constexpr double k_golden = 0.6180339887498949;  // multiples of it are never close to each other
    constexpr double k_turn_seconds = 12.0;
    shift_ = k_golden * pass;
    std::vector<double> areas;
    double area_sum = 0.0;
    for (const FlightLine& line : lines) {
      check_that(line.pitch > -80.0 && line.pitch < 80.0, "flight line pitch out of range",
                 "degrees between -80 and 80");
      check_that(line.field_of_view > 0.0 && line.field_of_view < 160.0,
                 "flight line field of view out of range", "degrees between 0 and 160");
      const double height = line.start.z - ground_height;
      check_that(height > 0.0 && line.end.z == line.start.z, "the flight line is not level above the ground");
      Strip strip{.line = line, .seconds_begin = seconds_};
      const glm::dvec3 run = line.end - line.start;
      strip.length = glm::length(run);
      check_that(strip.length > 0.0, "the flight line has no length");
      strip.ahead = run / strip.length;
      strip.side = {strip.ahead.y, -strip.ahead.x, 0.0};
      const SineCosine pitch = sine_cosine_by_quarters(radians(line.pitch)),
                       half = sine_cosine_by_quarters(radians(0.5 * line.field_of_view));
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
      const auto end = i + 1 == strips_.size()
                           ? count
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

  std::uint64_t count() const { return count_; }
  double seconds() const { return seconds_; }
  /// Index of the line a beam belongs to. Beams are in the order of the lines.
  std::size_t line_of(std::uint64_t index) const {
    const auto after = std::upper_bound(
        strips_.begin(), strips_.end(), index,
        [](std::uint64_t beam, const Strip& strip) { return beam < strip.begin + strip.count; });
    return static_cast<std::size_t>(after - strips_.begin());
  }

  Beam beam(std::uint64_t index) const {
    const Strip& strip = strips_[line_of(index)];
    const double share = (static_cast<double>(index - strip.begin) + 0.5) / static_cast<double>(strip.count);
    const double sweeps = share * strip.sweeps + shift_;
    const double degrees = strip.line.field_of_view * (sweeps - std::floor(sweeps) - 0.5);
    const SineCosine across = sine_cosine_by_quarters(radians(degrees));
    const glm::dvec3 origin = strip.line.start + share * strip.length * strip.ahead;
    return {make_ray(origin, across.cosine * strip.down + across.sine * strip.side, 0.0, scanner_.range_max),
            static_cast<float>(degrees), strip.seconds_begin + share * strip.length / scanner_.speed};
  }

 private:
  struct Strip {
    FlightLine line;
    std::uint64_t begin = 0, count = 0;
    double sweeps = 1.0;
    double seconds_begin = 0.0;
    double length = 0.0;
    glm::dvec3 ahead{0.0}, side{0.0}, down{0.0};  ///< of the flight; `down` is tilted by the pitch
  };

  DroneScanner scanner_;
  std::vector<Strip> strips_;
  std::uint64_t count_ = 0;
  double seconds_ = 0.0;
  double shift_ = 0.0;  ///< of the sweeps, in parts of a sweep
};

constexpr std::uint64_t k_beams_per_batch = 32768;
/// Batches that are processed at once; more than threads, so that none waits. Bounds the memory.
constexpr std::size_t k_batches_under_way = 16;

/// Nearly normal deviate, variance 1, within +-4.9: the sum of eight 16-bit uniform numbers, which doubles
/// hold exactly.
double deviate(std::uint64_t seed, std::uint64_t source, std::uint64_t beam) {
  const std::uint64_t bits[] = {hash_of(seed ^ (source << 48), beam), hash_of(~seed ^ (source << 48), beam)};
  std::uint64_t sum = 0;
  for (const std::uint64_t word : bits)
    for (int shift = 0; shift < 64; shift += 16) sum += (word >> shift) & 0xffffu;
  // sqrt(8 / 12) of a uniform number over 65536.
  constexpr double k_deviation = 0.81649658092772603 * 65536.0;
  return (static_cast<double>(sum) - 4.0 * 65535.0) / k_deviation;
}

std::uint16_t to_16_bits(double share) {
  return static_cast<std::uint16_t>(std::floor(std::clamp(share, 0.0, 1.0) * 65535.0 + 0.5));
}

/// Values that all beams of a batch share.
struct Emission {
  std::uint64_t seed = 0;
  std::uint64_t pass = 0;  ///< separates the noise of one scan from that of another
  double range_noise = 0.0;
  double start_time = 0.0;  ///< GPS seconds
};

/// Sends one beam and appends the point it gives, if it meets the site.
void measure(const Site& site, const Emission& emission, const Beam& beam, std::uint64_t index,
             std::uint16_t source, PointCloud& batch) {
  const std::optional<SiteHit> hit = site.closest(beam.ray);
  if (!hit) return;
  const double range = hit->t + emission.range_noise * deviate(emission.seed, emission.pass, index);
  const std::optional<LatticePosition> position = to_lattice(batch.lattice, beam.ray.position(range));
  if (!position)
    throw Error(
        {.problem = "a scanned point exceeds the range of the 1 mm lattice around the site's origin"});
  const double facing = std::fabs(glm::dot(hit->normal, beam.ray.direction));
  constexpr double k_half_range = 40.0;  // metres over which the returned signal falls to a half
  const double echo =
      reflectance_of(hit->material, hit->color) * (0.25 + 0.75 * facing) / (1.0 + hit->t / k_half_range);

  batch.positions.push_back(*position);
  batch.colors.emplace_back(to_16_bits(hit->color.x), to_16_bits(hit->color.y), to_16_bits(hit->color.z));
  batch.intensities.push_back(to_16_bits(echo));
  batch.classifications.push_back(hit->classification);
  batch.returns.push_back({1, 1});
  batch.scan_angles.push_back(beam.scan_angle);
  batch.point_source_ids.push_back(source);
  batch.gps_times.push_back(emission.start_time + beam.seconds);
}

void reserve(PointCloud& batch, std::size_t count) {
  batch.positions.reserve(count);
  for_each_column(batch, batch, [&](Attribute attribute, auto& column, auto&) {
    if (scan_attributes().contains(attribute)) column.reserve(count);
  });
}

/// Passes batches to the sink until it has all requested points.
struct Delivery {
  const ScanOptions& options;
  const PointSink& sink;
  const Progress& progress;
  std::uint64_t delivered = 0;

  std::uint64_t missing() const { return options.point_count - delivered; }

  void take(PointCloud& batch) {
    if (batch.size() > missing()) batch.resize(static_cast<std::size_t>(missing()));
    if (batch.size() == 0) return;
    sink(batch);
    const std::uint64_t before = delivered;
    delivered += batch.size();
    constexpr std::uint64_t k_points_per_report = 131072;
    if (delivered / k_points_per_report != before / k_points_per_report || missing() == 0)
      report(progress, delivered, options.point_count);
  }
};

/// Sends beams 0 .. count-1 in parallel batches, which reach the delivery in order. `beam_of(index)` returns
/// the beam and its source.
template <typename BeamOf>
void send_beams(const Site& site, const PointCloud& header, const Emission& emission, std::uint64_t count,
                const BeamOf& beam_of, Delivery& delivery) {
  /// The result of a batch. Exceptions are part of it, and are thrown again after the pipeline: one thrown
  /// inside would lose the batches in process.
  struct Traced {
    PointCloud points;
    std::exception_ptr failure;
  };
  std::exception_ptr failure;
  std::atomic<bool> finished = false;
  std::uint64_t next = 0;
  const auto begin_batch = [&](tbb::flow_control& control) {
    if (next >= count || finished) control.stop();
    return std::exchange(next, next + k_beams_per_batch);
  };
  const auto trace = [&](std::uint64_t begin) {
    const auto traced = std::make_shared<Traced>();
    try {
      const std::uint64_t end = std::min(count, begin + k_beams_per_batch);
      traced->points = header;
      reserve(traced->points, static_cast<std::size_t>(end - begin));
      for (std::uint64_t index = begin; index < end; ++index) {
        const auto [beam, source_id] = beam_of(index);
        measure(site, emission, beam, index, source_id, traced->points);
      }
    } catch (...) {
      traced->failure = std::current_exception();
    }
    return traced;
  };
  const auto deliver = [&](const std::shared_ptr<Traced>& traced) {
    if (finished) return;
    try {
      if (traced->failure) std::rethrow_exception(traced->failure);
      delivery.take(traced->points);
    } catch (...) {
      failure = std::current_exception();
    }
    finished = failure != nullptr || delivery.missing() == 0;
  };
  tbb::parallel_pipeline(
      k_batches_under_way,
      tbb::make_filter<void, std::uint64_t>(tbb::filter_mode::serial_in_order, begin_batch) &
          tbb::make_filter<std::uint64_t, std::shared_ptr<Traced>>(tbb::filter_mode::parallel, trace) &
          tbb::make_filter<std::shared_ptr<Traced>, void>(tbb::filter_mode::serial_in_order, deliver));
  if (failure) std::rethrow_exception(failure);
}

/// Sum over the stations of the share of beams that meet the site, from a coarse raster of some ten thousand
/// beams each.
double survey(const Site& site, const ScanOptions& options) {
  constexpr double k_survey_steps_per_degree = 0.5;
  const StationBeams beams(options.terrestrial, k_survey_steps_per_degree);
  const std::uint64_t count = beams.count() * options.stations.size();
  const std::uint64_t hits = tbb::parallel_reduce(
      tbb::blocked_range<std::uint64_t>(0, count, 256), std::uint64_t{0},
      [&](const tbb::blocked_range<std::uint64_t>& range, std::uint64_t sum) {
        for (std::uint64_t i = range.begin(); i < range.end(); ++i)
          if (site.occluded(beams.beam(options.stations[i / beams.count()], i % beams.count()).ray)) ++sum;
        return sum;
      },
      std::plus<>());
  return static_cast<double>(hits) / static_cast<double>(beams.count());
}

constexpr double k_first_second = 402'000'000.0;  // adjusted GPS time: a day in the summer of 2024
constexpr double k_pause = 60.0;                  // between one scan and the next

void check(const ScanOptions& options) {
  if (options.flight_lines.empty()) throw Error({.problem = "a scan requires a flight line"});
  check_that(options.terrestrial_share >= 0.0 && options.terrestrial_share <= 1.0,
             "share of points from the stations out of range", "0 to 1");
  check_that(options.terrestrial.elevation_min < options.terrestrial.elevation_max &&
                 options.terrestrial.elevation_min >= -90.0 && options.terrestrial.elevation_max <= 90.0,
             "invalid scanner elevation limits", "-90 to 90 degrees, the lower limit first");
}

}  // namespace

PointCloud scan_header(const Site& site) {
  PointCloud cloud;
  cloud.lattice = {glm::dvec3(0.001), site.origin()};
  cloud.gps_time_is_standard = true;
  cloud.crs.wkt = R"(PROJCS["WGS 84 / UTM zone 32N",GEOGCS["WGS 84",)"
                  R"(DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563,AUTHORITY["EPSG","7030"]],)"
                  R"(AUTHORITY["EPSG","6326"]],PRIMEM["Greenwich",0,AUTHORITY["EPSG","8901"]],)"
                  R"(UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],AUTHORITY["EPSG","4326"]],)"
                  R"(PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],)"
                  R"(PARAMETER["central_meridian",9],PARAMETER["scale_factor",0.9996],)"
                  R"(PARAMETER["false_easting",500000],PARAMETER["false_northing",0],)"
                  R"(UNIT["metre",1,AUTHORITY["EPSG","9001"]],)"
                  R"(AXIS["Easting",EAST],AXIS["Northing",NORTH],AUTHORITY["EPSG","32632"]])";
  return cloud;
}

AttributeSet scan_attributes() {
  return Attribute::color | Attribute::intensity | Attribute::classification | Attribute::returns |
         Attribute::scan_angle | Attribute::point_source_id | Attribute::gps_time;
}

void scan(const Site& site, const ScanOptions& options, const PointSink& sink, const Progress& progress) {
  check(options);
  const PointCloud header = scan_header(site);
  Delivery delivery{options, sink, progress};
  Emission emission{options.seed, 0, options.terrestrial.range_noise, k_first_second};

  const double share = options.stations.empty() ? 0.0 : survey(site, options);
  const double wanted = options.terrestrial_share * static_cast<double>(options.point_count);
  if (share > 0.0 && wanted >= 1.0) {
    const double degrees = 360.0 * (options.terrestrial.elevation_max - options.terrestrial.elevation_min);
    const StationBeams beams(options.terrestrial, std::sqrt(wanted / (share * degrees)));
    for (std::size_t i = 0; i < options.stations.size(); ++i) {
      const auto source = static_cast<std::uint16_t>(i + 1);
      send_beams(
          site, header, emission, beams.count(),
          [&](std::uint64_t index) { return std::pair(beams.beam(options.stations[i], index), source); },
          delivery);
      ++emission.pass;
      emission.start_time += options.terrestrial.seconds + k_pause;
    }
  }

  emission.range_noise = options.drone.range_noise;
  constexpr int k_most_passes = 1000;
  double sent = 0.0, met = 0.0;
  for (int pass = 0; delivery.missing() > 0; ++pass) {
    // Until a beam has met the site, every beam is expected to.
    const double share_met = met > 0.0 ? met / sent : 1.0;
    auto count = static_cast<std::uint64_t>(std::ceil(static_cast<double>(delivery.missing()) / share_met));
    constexpr std::uint64_t k_second_try = 100000;
    if (pass > 0 && met == 0.0) count = std::max(count, k_second_try);
    if (pass == k_most_passes || (pass > 1 && met == 0.0))
      throw Error({.problem = "no pulse of the simulated flight hits the site"});

    const std::uint64_t before = delivery.delivered;
    const FlightBeams beams(options.drone, options.flight_lines, site.origin().z, count, pass);
    send_beams(
        site, header, emission, count,
        [&](std::uint64_t index) {
          return std::pair(beams.beam(index),
                           static_cast<std::uint16_t>(options.stations.size() + beams.line_of(index) + 1));
        },
        delivery);
    sent += static_cast<double>(count);
    met += static_cast<double>(delivery.delivered - before);
    ++emission.pass;
    emission.start_time += beams.seconds() + k_pause;
  }
}

}  // namespace alidade::simulation
