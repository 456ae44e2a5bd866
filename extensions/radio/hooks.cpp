// SPDX-License-Identifier: MIT
#include <memory>
#include <optional>
#include <string>

#include "extensions/radio/fresnel_measure.h"
#include "jobs/visibility/lines.h"

namespace alidade::extensions {
namespace {

/// --frequency of `visibility lines`.
class Radio : public jobs::AddedLineMeasure {
 public:
  void add_fields(const jobs::Fields& fields) override {
    fields.group("Radio").value(
        "--frequency", "F[GHz|MHz]",
        "report the first Fresnel zone of this frequency, 5.8GHz or 868MHz; GHz without a unit. Sets the "
        "default of --earth-radius-factor to 1.3333",
        [this](const std::string& text) {
          frequency_ = visibility::parse_frequency(text);
          if (!frequency_)
            throw jobs::UsageError("invalid value; expected 1MHz to 1000GHz, found '" + text + "'");
        });
  }
  bool is_requested() const override { return frequency_.has_value(); }
  double earth_factor() const override { return 4.0 / 3.0; }
  std::size_t bytes_per_line() const override {
    return visibility::k_most_obstructions * sizeof(visibility::Obstruction);
  }
  std::shared_ptr<visibility::LineMeasure> measure(double unit) const override {
    return std::make_shared<visibility::FresnelMeasure>(visibility::k_speed_of_light / *frequency_ / unit);
  }

 private:
  std::optional<double> frequency_;  ///< Hz
};

std::shared_ptr<jobs::AddedLineMeasure> make_radio() {
  return std::make_shared<Radio>();
}

}  // namespace

void set_up_radio() {
  jobs::add_addition<jobs::AddedLineMeasure>(make_radio);
}

}  // namespace alidade::extensions
