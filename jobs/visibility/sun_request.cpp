// SPDX-License-Identifier: MIT
#include "jobs/visibility/sun_request.h"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/error.h"
#include "base/fingerprint.h"
#include "base/input_file.h"
#include "base/words.h"
#include "jobs/cloud_fields.h"
#include "jobs/visibility/run_fingerprint.h"

namespace alidade::jobs {
namespace {

constexpr double k_seconds_per_day = 86400.0;

Moment midnight(const Moment& utc, double longitude) {
  const double seconds = utc.seconds - std::round(longitude / 360.0 * k_seconds_per_day);
  const double days = std::floor(seconds / k_seconds_per_day);
  return {utc.day + std::chrono::days(static_cast<int>(days)), seconds - days * k_seconds_per_day};
}

/// Reads "2026-06-21", a day, or "2026-06-21T10:00Z", a moment with its zone (a blank may replace the T).
/// Errors: UsageError for anything else.
SunDate parse_sun_date(const std::string& text) {
  constexpr std::size_t k_date_length = 10;
  if (text.size() != k_date_length) return {parse_moment(text), false};
  try {
    return {parse_date_time(text + "T00:00Z"), true};
  } catch (const Error&) {
    // The message of the parser would contain the time that was appended here.
    throw UsageError("invalid date; expected a date such as 2026-06-21, found '" + text + "'");
  }
}

/// When a range that begins with the date begins, and when one that ends with it ends. Days begin and end at
/// the middle of the night: midnight of mean solar time, 4 minutes earlier per degree to the east.
Moment begin_of(const SunDate& date, double longitude) {
  return date.is_day ? midnight(date.moment, longitude) : date.moment;
}

Moment end_of(const SunDate& date, double longitude) {
  if (!date.is_day) return date.moment;
  Moment next = date.moment;
  next.day += std::chrono::days(1);
  return midnight(next, longitude);
}

/// "LAT,LON".
glm::dvec2 parse_location(const std::string& text) {
  const std::vector<std::string> words = split_list(text, 2, "two numbers separated by a comma");
  return {parse_number(words[0], -90.0, 90.0), parse_number(std::string(trim(words[1])), -360.0, 360.0)};
}

/// One number for all months, or twelve.
void parse_turbidity(const std::string& text, SunRequest& request) {
  const std::vector<std::string> words = split_list(text);
  const auto number = [](const std::string& word) { return parse_number(word, 1.0, 20.0); };
  std::array<double, 12> monthly{};
  if (words.size() == 1) {
    request.air.linke_turbidity = number(words.front());
    request.monthly_turbidity.reset();
    return;
  }
  if (words.size() != monthly.size())
    throw UsageError("invalid value; expected one number, or twelve separated by commas, found '" + text +
                     "'");
  std::ranges::transform(words, monthly.begin(), number);
  request.monthly_turbidity = monthly;
}

void add_time(const Fields& fields, SunRequest& request) {
  const Fields group = fields.group("Sun");
  group.required().value(
      "--from", "DATE",
      "first day, such as 2026-06-21, or start with a zone, such as 2026-06-21T10:00+02:00. Days "
      "begin and end at local midnight",
      request.from, parse_sun_date);
  group.value("--to", "DATE", "last day, included, or end (default: the day of --from)", request.to,
              parse_sun_date);
  group.number("--step", "MINUTES",
               "minutes between positions of the sun, each in the middle of its step (default: 10)",
               request.step_minutes, 0.1, 1440.0);
  group.choice("--per", "sum the whole time (default), or every year, month or day apart", request.period,
               {{"whole", visibility::SunPeriod::whole},
                {"year", visibility::SunPeriod::year},
                {"month", visibility::SunPeriod::month},
                {"day", visibility::SunPeriod::day}});
  group.value(
      "--place", "LAT,LON",
      "location in degrees, WGS 84 (default: the centre of the cloud by its reference system, else that of "
      "--weather)",
      request.location, parse_location);
  group.value(
      "--bin", "DEGREES|exact",
      "group sun positions into bins of this size (default: exact for up to 1000 positions; for more, 1 "
      "degree of azimuth over an elevation raster, else 3 degrees)",
      request.bin,
      [](const std::string& text) { return text == "exact" ? 0.0 : parse_number(text, 0.01, 30.0); });
}

void add_light(const Fields& fields, SunRequest& request) {
  const Fields group = fields.group("Radiation");
  group.file("--weather", "FILE",
             "direct and diffuse irradiances, clouds included: EPW, TMY3 or a typical year of PVGIS as CSV "
             "(default: a clear sky)",
             request.weather);
  group.value(
      "--turbidity", "T|T1,...,T12",
      "Linke turbidity of the clear sky, or that of each month: 2 very clear, 3 usual (default), 5 humid, 7 "
      "polluted",
      [&request](const std::string& text) { parse_turbidity(text, request); });
  group.number("--height", "METRES", "height above sea level, which thins the air (default: 0)",
               request.air.height, -1000.0, 10000.0);
  group.number(
      "--albedo", "SHARE",
      "share of light that the ground, and with --bounces 1 all surfaces reflect, 0 to 1 (default: 0.2)",
      request.albedo, 0.0, 1.0);
  group.count(
      "--bounces", "N",
      "1: whatever a receiver sees reflects the light of sun and sky that it gets itself; 0 (default): "
      "open level ground does",
      request.bounces, 0, 1);
  group.number("--tilt", "DEGREES", "tilt every receiver from the horizontal, 0 to 90, instead of --receiver",
               request.tilt, 0.0, 90.0);
  group.number("--aspect", "DEGREES",
               "azimuth that tilted receivers face, clockwise from north (default: 180)", request.aspect,
               -360.0, 360.0);
  group.flag("--beam-only", "direct sun alone: fewer lines of sight, no diffuse and reflected light",
             request.beam_only);
}

/// Whether light is computed from horizons: a raster alone blocks.
bool by_horizons(const SunRequest& request, const VisibilityCloud& cloud) {
  return !cloud.has_points() && cloud.mesh.tree == nullptr && std::isinf(request.max_distance);
}

std::string model_text(const SunSky& sun) {
  const visibility::SunSchedule& schedule = sun.schedule;
  if (sun.weather) return fmt::format("weather of the {} file", sun.weather->format());
  std::string turbidity = fmt::format("{:g}", schedule.air.linke_turbidity);
  if (schedule.monthly_turbidity)
    turbidity = fmt::format("{:g} from January to December", fmt::join(*schedule.monthly_turbidity, " "));
  return fmt::format(
      "clear sky of the European Solar Radiation Atlas, Linke turbidity {}, {:g} m above the sea", turbidity,
      schedule.air.height);
}

/// The energy of all periods on open level ground, kWh/m2.
visibility::LightSums open_energy(const SunSky& sun) {
  visibility::LightSums all;
  for (const visibility::LightSums& period : sun.light.open) all += period;
  all.beam /= 1000.0;
  all.diffuse /= 1000.0;
  return all;
}

std::size_t direction_count(const SunSky& sun) {
  return sun.light.bins.size() + sun.light.fans.size();
}

void warn_of_weather(const SunSky& sun, Listener& listener) {
  if (const std::size_t missing = sun.weather->missing_hours(); missing > 0)
    listener.warn(
        fmt::format("hours of the weather file without irradiances, which are taken as 0: {}", missing));
  const double away = std::hypot(sun.weather->latitude() - sun.schedule.latitude,
                                 std::remainder(sun.weather->longitude() - sun.schedule.longitude, 360.0));
  if (away > 1.0)
    listener.warn(fmt::format("the weather is that of latitude {:g}, longitude {:g}, {:.1f} degrees away",
                              sun.weather->latitude(), sun.weather->longitude(), away));
}

constexpr std::array<SunQuantity, 5> k_quantities{{
    {"SunHours", "h", "hours of direct sun", [](const visibility::Radiation& one) { return one.hours; }},
    {"BeamEnergy", "Wh/m2", "direct sun, Wh/m2", [](const visibility::Radiation& one) { return one.beam; }},
    {"DiffuseEnergy", "Wh/m2", "light of the sky, Wh/m2",
     [](const visibility::Radiation& one) { return one.diffuse; }},
    {"ReflectedEnergy", "Wh/m2", "reflected light, Wh/m2",
     [](const visibility::Radiation& one) { return one.reflected; }},
    {"GlobalEnergy", "Wh/m2", "all light, Wh/m2",
     [](const visibility::Radiation& one) { return one.global(); }},
}};

}  // namespace

visibility::SunHoursOptions SunRequest::hours_options(visibility::SkyReceiver usual) const {
  visibility::SunHoursOptions options{.receiver = receiver.value_or(usual),
                                      .max_distance = max_distance,
                                      .albedo = albedo,
                                      .bounces = bounces};
  if (tilt || aspect) options.normal = visibility::tilted_normal(tilt.value_or(0.0), aspect.value_or(180.0));
  return options;
}

std::span<const SunQuantity> sun_quantities(const SunRequest& request) {
  return std::span(k_quantities).first(request.beam_only ? 2 : k_quantities.size());
}

std::unique_ptr<SunSky> sun_of(const SunRequest& request, const VisibilityCloud& cloud, Listener& listener,
                               std::optional<std::size_t> targets) {
  // With fewer steps bins would save little time.
  constexpr std::size_t k_most_exact_steps = 1000, k_most_exact_lines = 10'000'000;
  constexpr double k_usual_bin = 3.0, k_usual_fan = 1.0;
  auto sun = std::make_unique<SunSky>();
  visibility::SunSchedule& schedule = sun->schedule;
  std::optional<glm::dvec2> location = request.location;
  if (!request.weather.empty()) {
    InputFile file(request.weather);
    sun->weather.emplace(file);
    schedule.weather = &*sun->weather;
    if (cloud.cloud.cloud.crs.empty() && !location)
      location = glm::dvec2(sun->weather->latitude(), sun->weather->longitude());
  }
  sun->is_map_known = visibility::place_schedule(cloud.cloud.cloud.crs, glm::dvec2(cloud.area().center()),
                                                 location, schedule);
  schedule.from = begin_of(*request.from, schedule.longitude);
  schedule.to = end_of(request.to.value_or(*request.from), schedule.longitude);
  schedule.step_minutes = request.step_minutes;
  schedule.air = request.air;
  schedule.monthly_turbidity = request.monthly_turbidity;
  schedule.period = request.period;
  const std::vector<visibility::SunStep> steps =
      in_stage(listener, "computing sun positions", "steps",
               [&](const Progress& progress) { return visibility::sun_steps(schedule, progress); });
  sun->periods = visibility::sun_periods(schedule);
  sun->steps = steps.size();
  for (const visibility::SunStep& step : steps) sun->hours += step.hours;
  const bool fans = by_horizons(request, cloud);
  const std::size_t most_steps =
      targets ? std::max(k_most_exact_steps, k_most_exact_lines / std::max<std::size_t>(*targets, 1))
              : k_most_exact_steps;
  const double usual = steps.size() <= most_steps ? 0.0 : fans ? k_usual_fan : k_usual_bin;
  sun->bin = request.bin.value_or(usual);
  sun->light = visibility::sun_light(steps, static_cast<int>(sun->periods.size()),
                                     {.bin = sun->bin, .has_sky = !request.beam_only, .by_horizons = fans});
  return sun;
}

void add_to_fingerprint(const SunSky& sun, Fingerprint& fingerprint) {
  std::vector<double> numbers;
  const auto put = [&](const visibility::LightSums& sums) {
    for (const double number :
         {sums.hours, sums.beam.x, sums.beam.y, sums.beam.z, sums.diffuse.x, sums.diffuse.y, sums.diffuse.z})
      numbers.push_back(number);
  };
  for (const visibility::LightBin& bin : sun.light.bins) {
    numbers.insert(numbers.end(), {bin.direction.x, bin.direction.y, bin.direction.z});
    for (const auto& share : bin.shares) {
      numbers.push_back(share.period);
      put(share.sums);
    }
  }
  for (const visibility::LightFan& fan : sun.light.fans) {
    numbers.insert(numbers.end(), {fan.direction.x, fan.direction.y});
    for (const auto& share : fan.shares) {
      numbers.push_back(share.period);
      numbers.insert(numbers.end(), share.slopes.begin(), share.slopes.end());
      for (const visibility::LightSums& sums : share.sums) put(sums);
    }
  }
  for (const visibility::LightSums& sums : sun.light.open) put(sums);
  add_to_fingerprint("path of the sun", numbers, fingerprint);
}

void say_sun(const SunRequest& request, const SunSky& sun, Listener& listener) {
  if (!listener.is_listening()) return;
  const visibility::SunSchedule& schedule = sun.schedule;
  listener.note(
      fmt::format("sun from {} to {} at latitude {:.5f}, longitude {:.5f}; {}", date_time_text(schedule.from),
                  date_time_text(schedule.to), schedule.latitude, schedule.longitude,
                  sun.is_map_known ? fmt::format("grid north is {:.4f} degrees off", schedule.grid_north)
                                   : "+y taken for true north"));
  listener.note(fmt::format("up for {:.2f} hours, {} steps, {} {}{}", sun.hours, sun.steps,
                            direction_count(sun),
                            sun.light.fans.empty() ? "directions" : "azimuths of horizons",
                            sun.bin > 0.0 ? fmt::format(" (bins of {:g} degrees)", sun.bin) : ""));
  const visibility::LightSums open = open_energy(sun);
  listener.note(
      fmt::format("open ground receives {:.3f} kWh/m2 of direct sun{} ({})", open.beam.z,
                  request.beam_only ? "" : fmt::format(" and {:.3f} kWh/m2 of the sky", open.diffuse.z),
                  model_text(sun)));
  if (sun.steps == 0) listener.warn("the sun is always below the horizon");
  if (sun.weather) warn_of_weather(sun, listener);
}

MapMetadata sun_metadata(const SunRequest& request, const SunSky& sun) {
  const visibility::SunSchedule& schedule = sun.schedule;
  std::string receiver =
      request.receiver == visibility::SkyReceiver::surface ? "slope of the ground" : "horizontal";
  if (request.tilt || request.aspect)
    receiver =
        fmt::format("tilt {:g}, aspect {:g}", request.tilt.value_or(0.0), request.aspect.value_or(180.0));
  return {{"alidade_sun_from", date_time_text(schedule.from)},
          {"alidade_sun_to", date_time_text(schedule.to)},
          {"alidade_sun_step_minutes", fmt::format("{:g}", schedule.step_minutes)},
          {"alidade_sun_directions", std::to_string(direction_count(sun))},
          {"alidade_sun_bin_degrees", sun.bin > 0.0 ? fmt::format("{:g}", sun.bin) : "exact"},
          {"alidade_sun_receiver", receiver},
          {"alidade_sun_albedo", fmt::format("{:g}", request.albedo)},
          {"alidade_sun_bounces", std::to_string(request.bounces)},
          {"alidade_place", fmt::format("latitude {:.6f}, longitude {:.6f}, grid north {:.6f}",
                                        schedule.latitude, schedule.longitude, schedule.grid_north)},
          {"alidade_sky", model_text(sun)}};
}

void add_sun_fields(const Fields& fields, SunRequest& request) {
  add_cloud(fields, request.files, {"--ignore-classes"});
  add_sky_site_fields(fields, request);
  add_time(fields, request);
  add_light(fields, request);
  add_observer_positions(fields, request.observers);
  fields.group(k_observer_group)
      .file("--diagram", "FILE.png", "also draw the paths of the sun over the skyline of a single observer",
            request.diagram);
  add_partial(fields, request.partial);
}

}  // namespace alidade::jobs
