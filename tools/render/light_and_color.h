// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <vector>

#include "image/point_color.h"
#include "renderer/render.h"
#include "renderer/scene.h"
#include "tools/options.h"

namespace alidade::tools {

/// The options of light of `alidade render`. Members that are empty leave the scene unchanged.
struct LightRequest {
  std::optional<renderer::RenderMode> mode;
  std::optional<std::optional<double>> ao_distance;  ///< an empty distance in it is "auto"
  std::optional<glm::dvec2> sun;                     ///< azimuth and elevation, degrees
  std::optional<Moment> sun_time;
  std::optional<glm::dvec2> sun_place;  ///< latitude and longitude, degrees
  bool no_sun = false;
};

/// Declares the options; they fill `request`.
void add_light_options(const Fields& render, LightRequest& request);

/// Applies the options to the scene. A sun that gets another position in the sky keeps its brightness, one
/// that gets another time keeps all else; one that had no time keeps its angular diameter only, since
/// brightness depends on elevation. Errors: a location for a sun that has no time; a sun or a distance that
/// the mode does not use.
void apply_light_options(const LightRequest& request, renderer::Scene& scene);

/// Error, naming the option, unless the scene's images show light of the sun and of surfaces.
void require_path_mode(const renderer::Scene& scene, const std::string& option);

/// Reads the image of the scene's sky, if it has one and its mode shows it, and prints its warnings.
/// Errors: as read_sky_image, naming the scene file.
void prepare_sky(renderer::Scene& scene, const std::filesystem::path& scene_file, Verbosity verbosity);

/// Completes the scene's light by its cloud (may be null), as far as its mode needs it: computes the position
/// of a sun by time, which is left out below the horizon, and the distance of ambient occlusion, and prints
/// both. Errors: as place_sun.
void prepare_light(renderer::Scene& scene, const renderer::LoadedCloud* cloud, Verbosity verbosity);

/// The options of colours on the command line. Members that are empty leave the scene unchanged.
struct ColorRequest {
  std::optional<std::string> by;
  std::optional<std::optional<image::ColorMap>> map;  ///< an empty map in it is "auto"
  std::optional<image::ValueRange> range, percentiles;
  std::vector<image::ClassColor> classes;
  std::filesystem::path legend;  ///< empty: none
  std::optional<glm::ivec2> legend_size;
};

/// Declares the options; they fill `request`, which must live as long as the program's options.
void add_color_options(const Fields& command, ColorRequest& request);

/// The name of one of the given options; empty if there is none.
std::string given_option(const ColorRequest& request);

/// Applies the options to a scene's colouring. Another attribute to colour by replaces all of the colouring,
/// since map and range belong to the scene's attribute. Errors: a legend for the points' own colours.
void apply(const ColorRequest& request, image::PointColoring& coloring);

}  // namespace alidade::tools
