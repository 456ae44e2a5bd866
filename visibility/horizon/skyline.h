// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "base/progress.h"
#include "image/canvas.h"
#include "image/film.h"
#include "image/font.h"
#include "visibility/horizon/horizon.h"
#include "visibility/sight_line.h"

namespace alidade::visibility {

/// Everything around an eye as distances: the layers depth, distance (equal, as a panorama has no axis) and
/// id (point id + 1) of a panorama_camera() (camera/camera.h) at the eye, whose middle column looks north.
/// Pixels without a blocker within max_distance have infinite distances and id 0, those of a mesh or terrain
/// its distance and id 0. A pixel shows the first blocker of the line through its centre (sight_line.h).
/// Requires sides of at least 1 pixel. Cost: a line per pixel, in parallel. `progress` is in pixels.
image::Film depth_panorama(const Occluders& occluders, const SightEnd& eye, int width, int height,
                           double max_distance = std::numeric_limits<double>::infinity(),
                           const Progress& progress = {});

/// Distances over a part of the view from an eye, pixel by pixel, row 0 on top. Column x looks to
/// azimuth_min + (x + 1/2) / width of the range of azimuths, rows likewise down from elevation_max.
struct DepthStrip {
  int width = 0, height = 0;
  double azimuth_min = 0.0, azimuth_max = 360.0;  ///< degrees, azimuth_min < azimuth_max <= azimuth_min + 360
  double elevation_min = 0.0, elevation_max = 90.0;  ///< degrees
  std::vector<float> distances;                      ///< metres; infinity: sky
};

/// A strip of the right size and range of elevations for the skyline of this horizon: it shows the line and
/// elevations up to `highest` degrees, with some room above and below. `distances` is empty.
DepthStrip strip_around(std::span<const HorizonDirection> horizon, double azimuth_min, double azimuth_max,
                        double highest = 0.0);

/// Fills in the distances: a line per pixel, in parallel. `progress` is in pixels.
void fill_strip(const Occluders& occluders, const SightEnd& eye, double max_distance, DepthStrip& strip,
                const Progress& progress = {});

/// A line over the image, such as the path of the sun. Positions are azimuth and elevation, degrees; the
/// line is cut where the azimuth jumps by more than 180 degrees.
struct SkylineCurve {
  std::vector<glm::dvec2> positions;
  image::Rgb8 color{};
  double width = 2.0;   ///< pixels
  std::string label{};  ///< beside its highest point; empty: none
  struct Mark {
    glm::dvec2 position;
    std::string label;  ///< above the dot
  };
  std::vector<Mark> marks{};  ///< dots
};

/// Text around the image and curves over it.
struct SkylineTexts {
  std::string title;                   ///< above it
  std::string note;                    ///< below it
  std::string unit;                    ///< of distances: "m"; empty if unknown
  std::vector<SkylineCurve> curves{};  ///< faint where something hides them
};

/// The skyline as a plot: azimuth to the right, elevation up, coloured by distance (dark is near, on a
/// logarithmic scale with a bar beside it), the horizon line in red, curves bright over the sky and faint
/// over what hides them. Requires a filled strip.
image::Canvas draw_skyline(const DepthStrip& strip, std::span<const HorizonDirection> horizon,
                           const SkylineTexts& texts, const image::Font& font);

/// Writes the image of draw_skyline() as PNG, with the font of find_font(). The file is written completely
/// or not at all. Errors: as write_png() (image/image_file.h); no font.
void write_skyline(const DepthStrip& strip, std::span<const HorizonDirection> horizon,
                   const SkylineTexts& texts, const std::filesystem::path& file, bool overwrite);

}  // namespace alidade::visibility
