// SPDX-License-Identifier: MIT
#include "tools/render/light_and_color.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "renderer/render_modes.h"
#include "tools/image_module.h"
#include "tools/message.h"

namespace alidade {
namespace {

std::string without_blanks_around(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(' ');
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(' ') + 1 - begin);
}

/// Two numbers with a comma between, as maps show them: blanks around the comma are no matter.
glm::dvec2 parse_pair(const std::string& text, double largest_first, double largest_second) {
  const std::size_t comma = text.find(',');
  if (comma == std::string::npos)
    throw CLI::ValidationError("expected two numbers with a comma between, found '" + text + "'");
  return {parse_number(without_blanks_around(text.substr(0, comma)), -largest_first, largest_first),
          parse_number(without_blanks_around(text.substr(comma + 1)), -largest_second, largest_second)};
}

/// Between date and time a person may write a blank instead of the T of scene files.
Moment parse_moment(std::string text) {
  constexpr std::size_t k_date_length = 10;
  if (text.size() > k_date_length && text[k_date_length] == ' ') text[k_date_length] = 'T';
  try {
    return parse_date_time(text);
  } catch (const Error& error) {
    throw CLI::ValidationError(error.what());
  }
}

void place_sun_by_time(Scene& scene, const LoadedCloud* cloud, Verbosity verbosity) {
  std::optional<SceneMap> map;
  if (cloud != nullptr && cloud->octree.size() > 0)
    map = SceneMap{cloud->crs, glm::dvec2(visible_bounds(*cloud).center())};
  PlacedSun placed;
  load_sun_placer()(*scene.sun_by_time, map, placed, scene.sun_origin);
  scene.sun_by_time.reset();
  if (placed.is_up) scene.sun = placed.sun;
  if (verbosity == Verbosity::quiet) return;
  say_note(scene.sun_origin);
  if (!placed.is_up) {
    say_warning(fmt::format("the sun is below the horizon, at elevation {:.3f} degrees: it lights nothing",
                            placed.sun.elevation));
  }
}

}  // namespace

void add_light_options(CLI::App& render, LightRequest& request) {
  add_choice<RenderMode>(
      render, "--mode",
      "path: light of sun, sky and lamps (default); ambient_occlusion: colours, darker where other surfaces "
      "are "
      "near; headlight: colours lit from the camera, no shadows; flat: the colours themselves",
      request.mode, [] {
        std::vector<std::pair<std::string, RenderMode>> words;
        for (const NamedMode& each : k_modes) words.emplace_back(each.name, each.mode);
        return words;
      }());
  add_value(render, "--ao-distance", "METRES|auto",
            "what counts as near for ambient_occlusion (default auto: a twentieth of the cloud's diagonal)",
            [&request](const std::string& text) {
              if (text == "auto")
                request.ao_distance.emplace();
              else
                request.ao_distance.emplace(parse_number(text, 1e-6, 1e12));
            });
  CLI::Option* const sun = add_value(
      render, "--sun", "AZIMUTH,ELEVATION",
      "where the sun stands, degrees: azimuth clockwise from north (+y), elevation above the horizon; the "
      "scene's brightness stays",
      [&request](const std::string& text) {
        request.sun = parse_pair(text, 360.0, 90.0);
        if (request.sun->y == -90.0)
          throw CLI::ValidationError("expected an elevation above -90, found '" + text + "'");
      });
  CLI::Option* const time =
      add_value(render, "--sun-time", "DATE-TIME",
                "the sun as it stands then, such as 2026-06-21T12:00:00+02:00; brightness by elevation, even "
                "where the scene's sun by angles has its own",
                [&request](const std::string& text) { request.sun_time = parse_moment(text); })
          ->excludes(sun);
  CLI::Option* const place =
      add_value(render, "--sun-place", "LAT,LON",
                "latitude and longitude for --sun-time, degrees (default: from the cloud's reference system)",
                [&request](const std::string& text) { request.sun_place = parse_pair(text, 90.0, 180.0); })
          ->excludes(sun);
  render.add_flag("--no-sun", request.no_sun, "no sun, only the sky")
      ->option_text(" ")
      ->excludes(sun)
      ->excludes(time)
      ->excludes(place);
}

void apply_light_options(const LightRequest& request, Scene& scene) {
  scene.render.mode = request.mode.value_or(scene.render.mode);
  if (request.ao_distance) scene.render.ao_distance = *request.ao_distance;
  if (request.ao_distance && scene.render.mode != RenderMode::ambient_occlusion) {
    throw Error({.problem = "--ao-distance is for ambient occlusion only",
                 .expected = "--mode ambient_occlusion beside it"});
  }
  if (request.sun) require_path_mode(scene, "--sun");
  if (request.sun_time) require_path_mode(scene, "--sun-time");
  if (request.sun_place) require_path_mode(scene, "--sun-place");
  if (request.no_sun || request.sun) {
    Sun sun = scene.sun.value_or(Sun{});
    if (scene.sun_by_time) {
      sun.angular_diameter = scene.sun_by_time->angular_diameter;
      sun.irradiance = scene.sun_by_time->irradiance.value_or(sun.irradiance);
    }
    scene.sun.reset();
    scene.sun_by_time.reset();
    if (request.no_sun) return;
    sun.azimuth = request.sun->x;
    sun.elevation = request.sun->y;
    scene.sun = sun;
  }
  if (request.sun_time) {
    if (!scene.sun_by_time) {
      scene.sun_by_time.emplace();
      if (scene.sun) scene.sun_by_time->angular_diameter = scene.sun->angular_diameter;
    }
    scene.sun_by_time->moment = *request.sun_time;
    scene.sun.reset();
  }
  if (request.sun_place) {
    if (!scene.sun_by_time) {
      throw Error({.problem = "--sun-place without a time: the sun's place in the sky depends on both",
                   .expected = "--sun-time DATE-TIME beside it"});
    }
    scene.sun_by_time->latitude = request.sun_place->x;
    scene.sun_by_time->longitude = request.sun_place->y;
  }
}

void require_path_mode(const Scene& scene, const std::string& option) {
  if (scene.render.mode == RenderMode::path) return;
  const auto mode = std::ranges::find(k_modes, scene.render.mode, &NamedMode::mode);
  throw Error({.problem = option + " changes nothing in this mode",
               .expected = "--mode path",
               .found = std::string(mode->name)});
}

void prepare_sky(Scene& scene, const std::filesystem::path& scene_file, Verbosity verbosity) {
  if (scene.render.mode == RenderMode::flat) scene.sky = ConstantSky{};
  auto* const sky = std::get_if<ImageSky>(&scene.sky);
  if (sky == nullptr) return;
  SkyPixels pixels;
  try {
    load_sky_image_reader()(sky->file, pixels);
  } catch (const Error& error) {
    Error::Parts parts = error.parts();
    parts.problem += fmt::format(" (at /sky/file of {})", scene_file.string());
    throw Error(parts);
  }
  if (verbosity != Verbosity::quiet) {
    if (!pixels.warning.empty()) say_warning(pixels.warning);
    say_note(fmt::format("sky from {}, {} x {} pixels", sky->file.string(), pixels.width, pixels.height));
  }
  sky->image = std::make_shared<SkyImage>(std::move(pixels), sky->scale, sky->rotation);
}

void prepare_light(Scene& scene, const LoadedCloud* cloud, Verbosity verbosity) {
  if (scene.render.mode != RenderMode::path) scene.sun_by_time.reset();
  if (scene.sun_by_time) place_sun_by_time(scene, cloud, verbosity);
  if (scene.render.mode == RenderMode::ambient_occlusion) {
    const bool is_given = scene.render.ao_distance.has_value();
    scene.render.ao_distance = ambient_occlusion_distance(scene.render, cloud);
    if (verbosity != Verbosity::quiet && !is_given) {
      const double distance = *scene.render.ao_distance;
      say_note(std::isinf(distance)
                   ? "ambient occlusion at any distance (there is no cloud to tell what is near)"
                   : fmt::format("ambient occlusion within {:.4g} (from the size of the cloud)", distance));
    }
  }
}

}  // namespace alidade
