// SPDX-License-Identifier: MIT
#include "tools/visibility/sun_request.h"

#include <fmt/format.h>
#include <cmath>

#include "base/error.h"
#include "base/fingerprint.h"
#include "base/words.h"
#include "tools/command.h"

namespace alidade::tools {
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
void parse_turbidity(const std::string& text, SunCommand& command) {
  const std::vector<std::string> words = split_list(text);
  const auto number = [](const std::string& word) { return parse_number(word, 1.0, 20.0); };
  std::array<double, 12> monthly{};
  if (words.size() == 1) {
    command.air.linke_turbidity = number(words.front());
    command.monthly_turbidity.reset();
    return;
  }
  if (words.size() != monthly.size())
    throw UsageError("invalid value; expected one number, or twelve separated by commas, found '" + text +
                     "'");
  std::ranges::transform(words, monthly.begin(), number);
  command.monthly_turbidity = monthly;
}

void add_time(const Fields& sun, SunCommand& command) {
  const Fields group = sun.group("Sun");
  group.required().value(
      "--from", "DATE",
      "first day, such as 2026-06-21, or start with a zone, such as 2026-06-21T10:00+02:00. Days "
      "begin and end at local midnight",
      command.from, parse_sun_date);
  group.value("--to", "DATE", "last day, included, or end (default: the day of --from)", command.to,
              parse_sun_date);
  group.number("--step", "MINUTES",
               "minutes between positions of the sun, each in the middle of its step (default: 10)",
               command.step_minutes, 0.1, 1440.0);
  group.choice("--per", "sum the whole time (default), or every year, month or day apart", command.period,
               {{"whole", visibility::SunPeriod::whole},
                {"year", visibility::SunPeriod::year},
                {"month", visibility::SunPeriod::month},
                {"day", visibility::SunPeriod::day}});
  group.value(
      "--place", "LAT,LON",
      "location in degrees, WGS 84 (default: the centre of the cloud by its reference system, else that of "
      "--weather)",
      command.location, parse_location);
  group.value(
      "--bin", "DEGREES|exact",
      "group sun positions into bins of this size (default: exact for up to 1000 positions; for more, 1 "
      "degree of azimuth over an elevation raster, else 3 degrees)",
      command.bin,
      [](const std::string& text) { return text == "exact" ? 0.0 : parse_number(text, 0.01, 30.0); });
}

void add_light(const Fields& sun, SunCommand& command) {
  const Fields group = sun.group("Radiation");
  group.file("--weather", "FILE",
             "direct and diffuse irradiances, clouds included: EPW, TMY3 or a typical year of PVGIS as CSV "
             "(default: a clear sky)",
             command.weather);
  group.value(
      "--turbidity", "T|T1,...,T12",
      "Linke turbidity of the clear sky, or that of each month: 2 very clear, 3 usual (default), 5 humid, 7 "
      "polluted",
      [&command](const std::string& text) { parse_turbidity(text, command); });
  group.number("--height", "METRES", "height above sea level, which thins the air (default: 0)",
               command.air.height, -1000.0, 10000.0);
  group.number(
      "--albedo", "SHARE",
      "share of light that the ground, and with --bounces 1 all surfaces reflect, 0 to 1 (default: 0.2)",
      command.albedo, 0.0, 1.0);
  group.count(
      "--bounces", "N",
      "1: whatever a receiver sees reflects the light of sun and sky that it gets itself; 0 (default): "
      "open level ground does",
      command.bounces, 0, 1);
  group.number("--tilt", "DEGREES", "tilt every receiver from the horizontal, 0 to 90, instead of --receiver",
               command.tilt, 0.0, 90.0);
  group.number("--aspect", "DEGREES",
               "azimuth that tilted receivers face, clockwise from north (default: 180)", command.aspect,
               -360.0, 360.0);
  group.flag("--beam-only", "direct sun alone: fewer lines of sight, no diffuse and reflected light",
             command.beam_only);
}

/// Whether light is computed from horizons: a raster alone blocks.
bool by_horizons(const SunCommand& command, const VisibilityCloud& cloud) {
  return !cloud.has_points() && cloud.mesh.tree == nullptr && std::isinf(command.max_distance);
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

void warn_of_weather(const SunSky& sun) {
  if (const std::size_t missing = sun.weather->missing_hours(); missing > 0)
    say_warning(
        fmt::format("hours of the weather file without irradiances, which are taken as 0: {}", missing));
  const double away = std::hypot(sun.weather->latitude() - sun.schedule.latitude,
                                 std::remainder(sun.weather->longitude() - sun.schedule.longitude, 360.0));
  if (away > 1.0)
    say_warning(fmt::format("the weather is that of latitude {:g}, longitude {:g}, {:.1f} degrees away",
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

visibility::SunHoursOptions SunCommand::hours_options(visibility::SkyReceiver usual) const {
  visibility::SunHoursOptions options{.receiver = receiver.value_or(usual),
                                      .max_distance = max_distance,
                                      .albedo = albedo,
                                      .bounces = bounces};
  if (tilt || aspect) options.normal = visibility::tilted_normal(tilt.value_or(0.0), aspect.value_or(180.0));
  return options;
}

std::span<const SunQuantity> sun_quantities(const SunCommand& command) {
  return std::span(k_quantities).first(command.beam_only ? 2 : k_quantities.size());
}

std::unique_ptr<SunSky> sun_of(const SunCommand& command, const VisibilityCloud& cloud,
                               std::optional<std::size_t> targets) {
  // With fewer steps bins would save little time.
  constexpr std::size_t k_most_exact_steps = 1000, k_most_exact_lines = 10'000'000;
  constexpr double k_usual_bin = 3.0, k_usual_fan = 1.0;
  auto sun = std::make_unique<SunSky>();
  visibility::SunSchedule& schedule = sun->schedule;
  std::optional<glm::dvec2> location = command.location;
  if (!command.weather.empty()) {
    InputFile file(command.weather);
    sun->weather.emplace(file);
    schedule.weather = &*sun->weather;
    if (cloud.cloud.cloud.crs.empty() && !location)
      location = glm::dvec2(sun->weather->latitude(), sun->weather->longitude());
  }
  sun->is_map_known = visibility::place_schedule(cloud.cloud.cloud.crs, glm::dvec2(cloud.area().center()),
                                                 location, schedule);
  schedule.from = begin_of(*command.from, schedule.longitude);
  schedule.to = end_of(command.to.value_or(*command.from), schedule.longitude);
  schedule.step_minutes = command.step_minutes;
  schedule.air = command.air;
  schedule.monthly_turbidity = command.monthly_turbidity;
  schedule.period = command.period;
  const std::vector<visibility::SunStep> steps =
      with_progress("computing sun positions", "steps", command.verbosity,
                    [&](const Progress& progress) { return visibility::sun_steps(schedule, progress); });
  sun->periods = visibility::sun_periods(schedule);
  sun->steps = steps.size();
  for (const visibility::SunStep& step : steps) sun->hours += step.hours;
  const bool fans = by_horizons(command, cloud);
  const std::size_t most_steps =
      targets ? std::max(k_most_exact_steps, k_most_exact_lines / std::max<std::size_t>(*targets, 1))
              : k_most_exact_steps;
  const double usual = steps.size() <= most_steps ? 0.0 : fans ? k_usual_fan : k_usual_bin;
  sun->bin = command.bin.value_or(usual);
  sun->light = visibility::sun_light(steps, static_cast<int>(sun->periods.size()),
                                     {.bin = sun->bin, .has_sky = !command.beam_only, .by_horizons = fans});
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
  jobs::add_to_fingerprint("path of the sun", numbers, fingerprint);
}

void say_sun(const SunCommand& command, const SunSky& sun) {
  if (command.verbosity == Verbosity::quiet) return;
  const visibility::SunSchedule& schedule = sun.schedule;
  say_note(fmt::format("sun from {} to {} at latitude {:.5f}, longitude {:.5f}; {}",
                       date_time_text(schedule.from), date_time_text(schedule.to), schedule.latitude,
                       schedule.longitude,
                       sun.is_map_known ? fmt::format("grid north is {:.4f} degrees off", schedule.grid_north)
                                        : "+y taken for true north"));
  say_note(fmt::format("up for {:.2f} hours, {} steps, {} {}{}", sun.hours, sun.steps, direction_count(sun),
                       sun.light.fans.empty() ? "directions" : "azimuths of horizons",
                       sun.bin > 0.0 ? fmt::format(" (bins of {:g} degrees)", sun.bin) : ""));
  const visibility::LightSums open = open_energy(sun);
  say_note(fmt::format("open ground receives {:.3f} kWh/m2 of direct sun{} ({})", open.beam.z,
                       command.beam_only ? "" : fmt::format(" and {:.3f} kWh/m2 of the sky", open.diffuse.z),
                       model_text(sun)));
  if (sun.steps == 0) say_warning("the sun is always below the horizon");
  if (sun.weather) warn_of_weather(sun);
}

MapMetadata sun_metadata(const SunCommand& command, const SunSky& sun) {
  const visibility::SunSchedule& schedule = sun.schedule;
  std::string receiver =
      command.receiver == visibility::SkyReceiver::surface ? "slope of the ground" : "horizontal";
  if (command.tilt || command.aspect)
    receiver =
        fmt::format("tilt {:g}, aspect {:g}", command.tilt.value_or(0.0), command.aspect.value_or(180.0));
  return {{"alidade_sun_from", date_time_text(schedule.from)},
          {"alidade_sun_to", date_time_text(schedule.to)},
          {"alidade_sun_step_minutes", fmt::format("{:g}", schedule.step_minutes)},
          {"alidade_sun_directions", std::to_string(direction_count(sun))},
          {"alidade_sun_bin_degrees", sun.bin > 0.0 ? fmt::format("{:g}", sun.bin) : "exact"},
          {"alidade_sun_receiver", receiver},
          {"alidade_sun_albedo", fmt::format("{:g}", command.albedo)},
          {"alidade_sun_bounces", std::to_string(command.bounces)},
          {"alidade_place", fmt::format("latitude {:.6f}, longitude {:.6f}, grid north {:.6f}",
                                        schedule.latitude, schedule.longitude, schedule.grid_north)},
          {"alidade_sky", model_text(sun)}};
}

void add_sun_request(const Fields& sun, SunCommand& command) {
  add_time(sun, command);
  add_light(sun, command);
}

}  // namespace alidade::tools
