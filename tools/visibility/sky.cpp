// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include "tools/commands.h"
#include "tools/message.h"
#include "tools/visibility/sky.h"
#include "visibility/sky/sky_of_cloud.h"

namespace alidade {
namespace {

struct SkyCommand {
  SkyRequest request;
  int directions = 128;
};

SkyViewOptions sky_options(const SkyCommand& command) {
  SkyViewOptions options;
  options.directions = command.directions;
  options.receiver = command.request.receiver.value_or(SkyReceiver::surface);
  options.max_distance = command.request.max_distance;
  return options;
}

/// Answers what was found, for people.
std::string map_sky(const SkyCommand& command, const CommandLine& words, const SkySite& site,
                    LongRun& long_run) {
  const SkyRequest& request = command.request;
  ProgressLine line("looking at the sky", "cells", request.verbosity.verbosity());
  Raster<float> views = ground_sky_views(*site.cloud->occluders, *site.ground, site.grid,
                                         request.map.target_height.value_or(0.0), sky_options(command),
                                         {long_run.progress(line), long_run.parts()});
  line.finish();
  const std::string found =
      range_and_mean([&](std::size_t i) { return views.values[i]; }, views.values.size());
  const SkyBand band{views, "SkyView", ""};
  write_sky_map(request, words, site, std::span(&band, 1),
                {{"alidade_sky",
                  fmt::format("sky-view factor of a horizontal place, {} directions", command.directions)}},
                {.title = "How much of the sky is seen", .label = "sky-view factor"});
  return found;
}

std::string point_sky(const SkyCommand& command, const VisibilityCloud& cloud, LongRun& long_run) {
  const SkyRequest& request = command.request;
  const Verbosity verbosity = request.verbosity.verbosity();
  ProgressLine line("looking at the sky", "points", verbosity);
  const std::vector<float> views =
      point_sky_views(*cloud.occluders, cloud.columns.normals, sky_options(command),
                      {long_run.progress(line), long_run.parts()});
  line.finish();
  const auto value = [&views](std::size_t id) { return views[id]; };
  write_points(request.output, cloud.cloud,
               {result_column<float>("SkyView", "sky-view factor, 0 to 1", ScalarType::float32, value)},
               request.overwrite, verbosity);
  return range_and_mean(value, views.size());
}

ExitCode run(const SkyCommand& command, const CommandLine& words, const CLI::App& given) {
  const SkyRequest& request = command.request;
  const SkySite site = load_sky_site(request, 1);
  LongRun long_run(
      request.checkpoint, [&] { return sky_identity(given, site); }, request.verbosity.verbosity());
  measure_occluders(*site.cloud, request.occluders, request.verbosity.verbosity());
  const std::string found =
      request.is_map() ? map_sky(command, words, site, long_run) : point_sky(command, *site.cloud, long_run);
  long_run.finish();
  if (!request.verbosity.quiet)
    say_note(fmt::format("sky-view factors {}; wrote {}", found, request.output.string()));
  return ExitCode::done;
}

}  // namespace

Command add_visibility_sky(CLI::App& visibility, const CommandLine& words) {
  auto command = std::make_shared<SkyCommand>();
  CLI::App* const sky =
      visibility.add_subcommand("sky", "Say how much of the sky every point or place on the ground sees");
  add_sky_request(*sky, command->request);
  add_value(*sky, "--directions", "N",
            "lines of sight per point or cell (default: 128, for an error of about 0.01)",
            [command](const std::string& text) {
              command->directions = static_cast<int>(parse_count(text, 1, k_most_sky_directions));
            })
      ->group("Answers");
  sky->footer(
      "Form:\n"
      "  alidade visibility sky CLOUD... -o FILE.las|.laz|.ply|.tif [OPTIONS]\n"
      "\n"
      "The sky-view factor is the light of an even sky that a receiver gets, as a share of what a horizontal "
      "one gets\n"
      "under the open sky: 1 on open ground, 0.5 on an open wall. Points of a cloud are given back in their "
      "order, with\n"
      "all that they had, and\n"
      "  SkyView  float  sky-view factor\n"
      "The outside of a surface is where the cloud's normals point to, or else the side that sees more of "
      "the "
      "sky.\n"
      "Maps have the factor of horizontal places on the ground, and no value where there is no ground.\n"
      "\n"
      "Examples:\n"
      "  alidade visibility sky site.las -o sky.las\n"
      "  alidade visibility sky site.alidade --resolution 1 --directions 256 -o sky.tif\n");
  return {sky, [command, words, sky] {
            ExitCode code = ExitCode::failed;
            with_threads(command->request.threads, [&] { code = run(*command, words, *sky); });
            return code;
          }};
}

}  // namespace alidade
