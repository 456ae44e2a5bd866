// SPDX-License-Identifier: MIT
#include "tools/visibility/observer_options.h"

#include <utility>

#include "octree/error.h"
#include "tools/options.h"

namespace alidade {
namespace {

constexpr const char* k_group = "Observers";

/// Two angles with a comma between.
std::pair<double, double> parse_angles(const std::string& text, double least, double most) {
  const std::size_t comma = text.find(',');
  if (comma == std::string::npos)
    throw CLI::ValidationError("expected two angles with a comma between, found '" + text + "'");
  return {parse_number(text.substr(0, comma), least, most),
          parse_number(text.substr(comma + 1), least, most)};
}

void add_view(CLI::App& command, ObserverDefaults& defaults) {
  add_value(command, "--max-distance", "LENGTH",
            "nothing farther from the observer is seen (default: inf); along the line of sight",
            [&defaults](const std::string& text) {
              defaults.max_distance =
                  parse_length_limit(text).value_or(std::numeric_limits<double>::infinity());
            })
      ->group(k_group);
  add_value(command, "--horizontal-fov", "A0,A1",
            "field of view in degrees clockwise from north (+y), from A0 clockwise to A1: 350,10 looks north "
            "(default: 0,360)",
            [&defaults](const std::string& text) {
              const auto [from, to] = parse_angles(text, -360.0, 720.0);
              if (from == to)
                throw CLI::ValidationError("expected two angles that differ, found '" + text + "'");
              defaults.azimuth_min = from;
              defaults.azimuth_max = to;
            })
      ->group(k_group);
  add_value(command, "--vertical-fov", "E0,E1",
            "field of view in degrees up from the horizontal (default: -90,90)",
            [&defaults](const std::string& text) {
              const auto [low, high] = parse_angles(text, -90.0, 90.0);
              if (low > high)
                throw CLI::ValidationError("expected the lower angle first, found '" + text + "'");
              defaults.elevation_min = low;
              defaults.elevation_max = high;
            })
      ->group(k_group);
}

}  // namespace

void add_observer_options(CLI::App& command, ObserverOptions& options) {
  // The option may be repeated; each value is read at once, so that it is named if it is wrong.
  command
      .add_option_function<std::vector<std::string>>(
          "--observer",
          [&options](const std::vector<std::string>& texts) {
            for (const std::string& text : texts) options.places.push_back(parse_observer(text));
          },
          "where the eye is, or its foot with --observer-height; without Z the foot is on the ground. May be "
          "repeated")
      ->option_text("X,Y[,Z]")
      ->allow_extra_args(false)
      ->group(k_group);
  add_value(command, "--observer-height", "LENGTH",
            "of the eye above its foot (default: 0 for observers with a z, 2 for those on the ground)",
            [&options](const std::string& text) { options.defaults.height = parse_number(text, 0.0, 1e6); })
      ->group(k_group);
  add_view(command, options.defaults);
}

void add_target_height(CLI::App& command, std::optional<double>& height) {
  add_value(command, "--target-height", "LENGTH", "of what is looked at above the ground (default: 0)",
            [&height](const std::string& text) { height = parse_number(text, 0.0, 1e6); })
      ->group(k_group);
}

}  // namespace alidade
