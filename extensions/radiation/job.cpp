// SPDX-License-Identifier: MIT
#include "extensions/radiation/job.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/input_file.h"
#include "extensions/radiation/radiation_measure.h"

namespace alidade::jobs {
namespace {

constexpr std::array<SunQuantity, 5> k_quantities{{
    {"SunHours", "h", "hours of direct sun", [](const float* numbers) { return numbers[0]; }},
    {"BeamEnergy", "Wh/m2", "direct sun, Wh/m2", [](const float* numbers) { return numbers[1]; }},
    {"DiffuseEnergy", "Wh/m2", "light of the sky, Wh/m2", [](const float* numbers) { return numbers[2]; }},
    {"ReflectedEnergy", "Wh/m2", "reflected light, Wh/m2", [](const float* numbers) { return numbers[3]; }},
    {"GlobalEnergy", "Wh/m2", "all light, Wh/m2",
     [](const float* numbers) { return numbers[1] + numbers[2] + numbers[3]; }},
}};

/// One number for all months, or twelve.
void parse_turbidity(const std::string& text, RadiationRequest& request) {
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

std::string model_text(const RadiationRequest& request, const std::optional<visibility::Weather>& weather) {
  if (weather) return fmt::format("weather of the {} file", weather->format());
  std::string turbidity = fmt::format("{:g}", request.air.linke_turbidity);
  if (request.monthly_turbidity)
    turbidity = fmt::format("{:g} from January to December", fmt::join(*request.monthly_turbidity, " "));
  return fmt::format(
      "clear sky of the European Solar Radiation Atlas, Linke turbidity {}, {:g} m above the sea", turbidity,
      request.air.height);
}

/// The light of the sun and of the sky.
class Light : public SunShine {
 public:
  explicit Light(const RadiationRequest& request) : request_(request) {
    if (request.weather.empty()) return;
    InputFile file(request.weather);
    weather_.emplace(file);
  }

  void begin(visibility::SunSchedule& schedule, std::optional<glm::dvec2>& location) override {
    schedule.height = request_.air.height;
    if (weather_ && !location) location = glm::dvec2(weather_->latitude(), weather_->longitude());
  }
  void set_path(const visibility::SunSchedule& schedule, std::span<const visibility::SunStep> steps,
                int periods, const visibility::LightOptions& options) override {
    const visibility::LightSource source{request_.air, request_.monthly_turbidity,
                                         weather_ ? &*weather_ : nullptr};
    light_ = visibility::energy_light(
        visibility::lit_steps(schedule, steps, source), periods,
        {.bin = options.bin, .has_sky = !request_.beam_only, .by_horizons = options.by_horizons});
  }
  std::size_t directions() const override { return light_.bins.size() + light_.fans.size(); }

  void note(Listener& listener) const override {
    visibility::LightSums open;  // on level ground, of all periods
    for (const visibility::LightSums& period : light_.open) open += period;
    listener.note(fmt::format(
        "open ground receives {:.3f} kWh/m2 of direct sun{} ({})", open.beam.z / 1000.0,
        request_.beam_only ? "" : fmt::format(" and {:.3f} kWh/m2 of the sky", open.diffuse.z / 1000.0),
        model_text(request_, weather_)));
  }
  void warn(const visibility::SunSchedule& schedule, Listener& listener) const override {
    if (!weather_) return;
    if (const std::size_t missing = weather_->missing_hours(); missing > 0)
      listener.warn(
          fmt::format("hours of the weather file without irradiances, which are taken as 0: {}", missing));
    const double away = std::hypot(weather_->latitude() - schedule.latitude,
                                   std::remainder(weather_->longitude() - schedule.longitude, 360.0));
    if (away > 1.0)
      listener.warn(fmt::format("the weather is that of latitude {:g}, longitude {:g}, {:.1f} degrees away",
                                weather_->latitude(), weather_->longitude(), away));
  }

  std::vector<double> fingerprint() const override {
    std::vector<double> numbers;
    append_light(
        light_,
        [](const visibility::LightSums& sums, std::vector<double>& all) {
          all.insert(all.end(), {sums.hours, sums.beam.x, sums.beam.y, sums.beam.z, sums.diffuse.x,
                                 sums.diffuse.y, sums.diffuse.z});
        },
        numbers);
    return numbers;
  }
  void add_metadata(MapMetadata& metadata) const override {
    metadata.insert(metadata.end() - 1, {{"alidade_sun_albedo", fmt::format("{:g}", request_.albedo)},
                                         {"alidade_sun_bounces", std::to_string(request_.bounces)}});
    metadata.push_back({"alidade_sky", model_text(request_, weather_)});
  }
  std::unique_ptr<visibility::SunMeasure> measure(const visibility::Occluders& occluders,
                                                  const visibility::SunHoursOptions& options,
                                                  double cell) const override {
    return std::make_unique<visibility::RadiationMeasure>(
        occluders, light_,
        visibility::RadiationOptions{.receiver = options.receiver,
                                     .max_distance = options.max_distance,
                                     .normal = options.normal,
                                     .albedo = request_.albedo,
                                     .bounces = request_.bounces},
        cell);
  }

 private:
  RadiationRequest request_;
  std::optional<visibility::Weather> weather_;
  visibility::EnergyLight light_;
};

}  // namespace

void AddedRadiation::add_fields(const Fields& fields) {
  const Fields group = fields.group("Radiation");
  group.file("--weather", "FILE",
             "direct and diffuse irradiances, clouds included: EPW, TMY3 or a typical year of PVGIS as CSV "
             "(default: a clear sky). A cloud without reference system is at its location without --place",
             request.weather);
  group.value(
      "--turbidity", "T|T1,...,T12",
      "Linke turbidity of the clear sky, or that of each month: 2 very clear, 3 usual (default), 5 humid, 7 "
      "polluted",
      [this](const std::string& text) { parse_turbidity(text, request); });
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
  group.flag("--beam-only", "direct sun alone: fewer lines of sight, no diffuse and reflected light",
             request.beam_only);
}

void AddedRadiation::check() const {
  if (request.beam_only && request.bounces > 0)
    throw input_error("--bounces 1 does not apply with --beam-only", "one of the two");
}

std::span<const SunQuantity> AddedRadiation::quantities() const {
  return std::span(k_quantities).first(request.beam_only ? 2 : k_quantities.size());
}

std::unique_ptr<SunShine> AddedRadiation::shine() const {
  return std::make_unique<Light>(request);
}

}  // namespace alidade::jobs
