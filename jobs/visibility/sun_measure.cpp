// SPDX-License-Identifier: MIT
#include "jobs/visibility/sun_measure.h"

#include <array>

namespace alidade::jobs {
namespace {

constexpr std::array<SunQuantity, 1> k_hours{
    {{"SunHours", "h", "hours of direct sun", [](const float* numbers) { return numbers[0]; }}}};

class Hours : public SunShine {
 public:
  void set_path(const visibility::SunSchedule&, std::span<const visibility::SunStep> steps, int periods,
                const visibility::LightOptions& options) override {
    light_ = visibility::sun_light(steps, periods, options);
  }
  std::size_t directions() const override { return light_.bins.size() + light_.fans.size(); }
  std::vector<double> fingerprint() const override {
    std::vector<double> numbers;
    append_light(
        light_, [](const visibility::SunHours& sums, std::vector<double>& all) { all.push_back(sums.hours); },
        numbers);
    return numbers;
  }
  std::unique_ptr<visibility::SunMeasure> measure(const visibility::Occluders& occluders,
                                                  const visibility::SunHoursOptions& options,
                                                  double) const override {
    return std::make_unique<visibility::SunHoursMeasure>(occluders, light_, options);
  }

 private:
  visibility::LightOf<visibility::SunHours> light_;
};

}  // namespace

std::span<const SunQuantity> quantity_of_hours() {
  return k_hours;
}

std::unique_ptr<SunShine> shine_of_hours() {
  return std::make_unique<Hours>();
}

}  // namespace alidade::jobs
