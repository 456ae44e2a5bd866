// SPDX-License-Identifier: MIT
#include "tools/render/light_and_color.h"

#include <fmt/format.h>
#include <cmath>

#include "base/words.h"
#include "geo/sun.h"
#include "image/read_image.h"
#include "renderer/integrator.h"

namespace alidade::tools {
namespace {

/// Two numbers separated by a comma; blanks around the comma are ignored, as maps on the web print them.
glm::dvec2 parse_pair(const std::string& text, double largest_first, double largest_second) {
  const std::vector<std::string> words = split_list(text, 2, "two numbers separated by a comma");
  return {parse_number(std::string(trim(words[0])), -largest_first, largest_first),
          parse_number(std::string(trim(words[1])), -largest_second, largest_second)};
}

void place_sun_by_time(renderer::Scene& scene, const renderer::LoadedCloud* cloud, Verbosity verbosity) {
  std::optional<geo::SceneMap> map;
  if (cloud != nullptr && cloud->octree.size() > 0)
    map = geo::SceneMap{cloud->crs, glm::dvec2(renderer::visible_bounds(*cloud).center())};
  const geo::PlacedSun placed = geo::place_sun(*scene.sun_by_time, map);
  scene.sun_origin = geo::describe(*scene.sun_by_time, placed);
  scene.sun_by_time.reset();
  if (placed.is_up) scene.sun = placed.sun;
  say_note(verbosity, scene.sun_origin);
  if (!placed.is_up) {
    say_warnings(verbosity,
                 {fmt::format("the sun is below the horizon, at elevation {:.3f} degrees: it gives no light",
                              placed.sun.elevation)});
  }
}

image::ValueRange parse_range(const std::string& text, double least, double most) {
  const std::vector<std::string> ends = split_list(text, 2, "two numbers");
  const image::ValueRange range{parse_number(ends[0], least, most), parse_number(ends[1], least, most)};
  if (!(range.low < range.high))
    throw UsageError("limits out of order; expected the smaller number first, found '" + text + "'");
  return range;
}

std::vector<image::ClassColor> parse_class_colors(const std::string& text) {
  std::vector<image::ClassColor> classes;
  for (const std::string& part : split_list(text)) {
    const std::size_t sign = part.find('=');
    const std::optional<Color16> color =
        sign == std::string::npos ? std::nullopt : image::parse_hex_color(part.substr(sign + 1));
    if (!color) throw UsageError("invalid value; expected CLASS=#rrggbb, found '" + part + "'");
    classes.push_back({static_cast<std::uint8_t>(parse_count(part.substr(0, sign), 0, 255)), *color});
  }
  return classes;
}

std::filesystem::path parse_legend(const std::string& text) {
  const std::filesystem::path file(text);
  if (file.extension() != ".png" && file.extension() != ".PNG")
    throw UsageError("unknown output format; expected the extension .png, found '" + text + "'");
  return file;
}

glm::ivec2 parse_legend_size(const std::string& text) {
  // Margins and a line of the smallest type take more than this, whatever the text of the legend.
  constexpr int k_least_side = 24;
  const ImageSize size = parse_image_size(text);
  if (size.width < k_least_side || size.height < k_least_side) {
    throw UsageError("invalid value; expected at least " + std::to_string(k_least_side) +
                     " pixels in each direction, found '" + text + "'");
  }
  return {size.width, size.height};
}

std::vector<std::pair<std::string, std::optional<image::ColorMap>>> map_words() {
  std::vector<std::pair<std::string, std::optional<image::ColorMap>>> words{{"auto", std::nullopt}};
  for (const image::NamedColorMap& known : image::k_color_maps) words.emplace_back(known.name, known.map);
  return words;
}

}  // namespace

void add_light_options(const Fields& render, LightRequest& request) {
  render.choice(
      "--mode",
      "path: light of sun, sky and lamps (default); ambient_occlusion: colours, darker where other surfaces "
      "are near; headlight: colours lit from the camera, no shadows; flat: colours without light",
      request.mode, [] {
        std::vector<std::pair<std::string, renderer::RenderMode>> words;
        for (const renderer::NamedMode& each : renderer::k_modes) words.emplace_back(each.name, each.mode);
        return words;
      }());
  render.value("--ao-distance", "METRES|auto",
               "range of ambient_occlusion (default auto: a twentieth of the cloud's diagonal)",
               request.ao_distance, [](const std::string& text) {
                 return text == "auto" ? std::nullopt : std::optional(parse_number(text, 1e-6, 1e12));
               });
  const Field sun = render.value(
      "--sun", "AZIMUTH,ELEVATION",
      "position of the sun, degrees: azimuth clockwise from north (+y), elevation above the "
      "horizon; the scene's brightness is kept",
      [&request](const std::string& text) {
        request.sun = parse_pair(text, 360.0, 90.0);
        if (request.sun->y == -90.0)
          throw UsageError("invalid value; expected an elevation above -90, found '" + text + "'");
      });
  const Field time =
      render.excludes(sun).value("--sun-time", "DATE-TIME",
                                 "the sun at this time, such as 2026-06-21T12:00:00+02:00; brightness by "
                                 "elevation, even if the scene's sun by angles sets one",
                                 request.sun_time, parse_moment);
  const Field place = render.excludes(sun).value(
      "--sun-place", "LAT,LON",
      "latitude and longitude for --sun-time, degrees (default: from the cloud's reference system)",
      request.sun_place, [](const std::string& text) { return parse_pair(text, 90.0, 180.0); });
  render.excludes(sun).excludes(time).excludes(place).flag("--no-sun", "no sun, only the sky",
                                                           request.no_sun);
}

void apply_light_options(const LightRequest& request, renderer::Scene& scene) {
  scene.render.mode = request.mode.value_or(scene.render.mode);
  if (request.ao_distance) scene.render.ao_distance = *request.ao_distance;
  if (request.ao_distance && scene.render.mode != renderer::RenderMode::ambient_occlusion)
    throw input_error("--ao-distance requires ambient occlusion", "--mode ambient_occlusion");
  if (request.sun) require_path_mode(scene, "--sun");
  if (request.sun_time) require_path_mode(scene, "--sun-time");
  if (request.sun_place) require_path_mode(scene, "--sun-place");
  if (request.no_sun || request.sun) {
    geo::Sun sun = scene.sun.value_or(geo::Sun{});
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
    if (!scene.sun_by_time)
      throw input_error("--sun-place requires --sun-time", "--sun-time DATE-TIME", "none");
    scene.sun_by_time->latitude = request.sun_place->x;
    scene.sun_by_time->longitude = request.sun_place->y;
  }
}

void require_path_mode(const renderer::Scene& scene, const std::string& option) {
  if (scene.render.mode == renderer::RenderMode::path) return;
  const auto mode = std::ranges::find(renderer::k_modes, scene.render.mode, &renderer::NamedMode::mode);
  throw input_error(option + " does not apply to this mode", "--mode path", std::string(mode->name));
}

void prepare_sky(renderer::Scene& scene, const std::filesystem::path& scene_file, Verbosity verbosity) {
  if (scene.render.mode == renderer::RenderMode::flat) scene.sky = renderer::ConstantSky{};
  auto* const sky = std::get_if<renderer::ImageSky>(&scene.sky);
  if (sky == nullptr) return;
  image::SkyPixels pixels;
  try {
    pixels = image::read_sky_image(sky->file);
  } catch (const Error& error) {
    Error::Parts parts = error.parts();
    parts.problem += fmt::format(" (at /sky/file of {})", scene_file.string());
    throw Error(parts);
  }
  if (verbosity != Verbosity::quiet) {
    if (!pixels.warning.empty()) say_warning(pixels.warning);
    say_note(fmt::format("sky from {}, {} x {} pixels", sky->file.string(), pixels.width, pixels.height));
  }
  sky->image = std::make_shared<renderer::SkyImage>(std::move(pixels), sky->scale, sky->rotation);
}

void prepare_light(renderer::Scene& scene, const renderer::LoadedCloud* cloud, Verbosity verbosity) {
  if (scene.render.mode != renderer::RenderMode::path) scene.sun_by_time.reset();
  if (scene.sun_by_time) place_sun_by_time(scene, cloud, verbosity);
  if (scene.render.mode == renderer::RenderMode::ambient_occlusion) {
    const bool is_given = scene.render.ao_distance.has_value();
    scene.render.ao_distance = renderer::ambient_occlusion_distance(scene.render, cloud);
    if (verbosity != Verbosity::quiet && !is_given) {
      const double distance = *scene.render.ao_distance;
      say_note(std::isinf(distance)
                   ? "ambient occlusion at any distance (there is no cloud to set the range)"
                   : fmt::format("ambient occlusion within {:.4g} (from the size of the cloud)", distance));
    }
  }
}

void add_color_options(const Fields& command, ColorRequest& request) {
  command.value(
      "--color-by,--color", "NAME",
      "attribute that colours the points: rgb, intensity, height, classification, normal, "
      "gps_time, return_number, number_of_returns, or another attribute by its name (default: "
      "rgb if the cloud has colours, else classification if it has several classes and at least half "
      "of the points one other than unclassified and noise, else height)",
      [&request](const std::string& text) {
        if (text.empty()) throw UsageError("missing value; expected a name");
        request.by = text;
      });
  command.choice("--color-map",
                 "colour map of values (default auto: grey for intensity, terrain for height, else viridis)",
                 request.map, map_words());
  const Field range = command.value(
      "--color-range", "MIN,MAX", "values of the first and last colour (default: by percentiles)",
      request.range, [](const std::string& text) {
        return parse_range(text, -image::k_largest_value, image::k_largest_value);
      });
  command.excludes(range).value(
      "--color-percentiles", "LOW,HIGH", "percentiles of the first and last colour (default 1,99)",
      request.percentiles, [](const std::string& text) { return parse_range(text, 0.0, 100.0); });
  command.value("--class-color", "CLASS=#RRGGBB,...",
                "colours of individual classes of --color-by classification", request.classes,
                parse_class_colors);
  const Field legend =
      command.value("--legend", "FILE.png",
                    "also write a legend: a colour bar, or the classes with their numbers of points",
                    request.legend, parse_legend);
  command.needs(legend).value("--legend-size", "WIDTHxHEIGHT",
                              "size of the legend in pixels (default: fits its text)", request.legend_size,
                              parse_legend_size);
}

std::string given_option(const ColorRequest& request) {
  if (request.by) return "--color-by";
  if (request.map) return "--color-map";
  if (request.range) return "--color-range";
  if (request.percentiles) return "--color-percentiles";
  if (!request.classes.empty()) return "--class-color";
  return request.legend.empty() ? "" : "--legend";
}

void apply(const ColorRequest& request, image::PointColoring& coloring) {
  if (request.by && *request.by != image::color_word(coloring)) coloring = image::coloring_by(*request.by);
  if (request.map) coloring.map = *request.map;
  if (request.range) coloring.range = request.range;
  if (request.percentiles) {
    coloring.percentiles = *request.percentiles;
    coloring.range.reset();
  }
  for (const image::ClassColor& change : request.classes) {
    const auto known = std::ranges::find(coloring.classes, change.number, &image::ClassColor::number);
    if (known == coloring.classes.end())
      coloring.classes.push_back(change);
    else
      known->color = change.color;
  }
  if (!request.legend.empty() && coloring.by == image::PointColor::rgb)
    image::check_legend({.by = image::PointColor::rgb});
}

}  // namespace alidade::tools
