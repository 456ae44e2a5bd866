// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <vector>

#include "image/point_color.h"

namespace alidade {

/// What was asked about colours on the command line. Everything that is empty is left as the scene has it.
struct ColorRequest {
  std::optional<std::string> by;
  std::optional<std::optional<ColorMap>> map;  ///< an empty map in it is "auto"
  std::optional<ValueRange> range, percentiles;
  std::vector<ClassColor> classes;
  std::filesystem::path legend;  ///< empty: none
  std::optional<glm::ivec2> legend_size;
};

/// Declares the options; they fill `request`, which must live as long as the program's options.
void add_color_options(CLI::App& command, ColorRequest& request);

/// The name of one of the options that were given; empty if there is none.
std::string given_option(const ColorRequest& request);

/// Lays the options over a scene's colouring. Another thing to colour by stands for all that the scene says
/// of it, since its map and range were meant for the scene's own. Errors: a legend for the points'
/// own colours.
void apply(const ColorRequest& request, PointColoring& coloring);

}  // namespace alidade
