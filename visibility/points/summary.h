// SPDX-License-Identifier: MIT
#pragma once

#include <bitset>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "base/checkpoint.h"
#include "base/progress.h"
#include "visibility/observers.h"
#include "visibility/row_text.h"
#include "visibility/sight_line.h"
#include "visibility/sky/sky_view.h"

// Comparable numbers of what each observer sees: the metrics of viewsheds and isovists.
//
//   const std::vector<ObserverSummary> all = summarize(occluders, observers, {.classes = classes});
//   if (all[0].sky.cosine_weighted > 0.5) ...
//
// Sources: extent, depth and its deviation, visible ground, relief and diversity are those of Tabrizian et
// al., Modeling restorative potential of urban environments by coupling viewscape analysis of lidar data with
// experiments in immersive virtual environments, 2020, and of the R package viewscape: there of the cells of
// a raster, here of the surface of the points. Isovists: Benedikt, To take hold of space: isovists and
// isovist fields, 1979; Davis and Benedikt, Computational models of space, 1979.

namespace alidade::visibility {

struct SummaryOptions {
  std::span<const std::uint8_t> classes{};  ///< by point id; empty: the cloud has none
  /// Ends of the bands of distance, metres, ascending, > 0: the first band begins at 0, one
  /// more is beyond the last end.
  std::vector<double> bands{10.0, 100.0, 1000.0};
  double step = 1.0;      ///< degrees between the azimuths of isovist and horizon, as HorizonOptions::step
  int directions = 4096;  ///< lines to the sky, and as many downwards, in [1, k_most_sky_directions]
  PartCheckpoint* parts = nullptr;  ///< where finished parts of point_visibility() are kept; null: nowhere
  Progress progress{};              ///< in sight lines to points
};

/// A distribution of distances, weighted by area, so that near surfaces, which have more
/// points, do not count more.
struct Spread {
  double min = 0.0, median = 0.0, mean = 0.0, max = 0.0, deviation = 0.0;
};

struct BandSummary {
  double visible = 0.0, all = 0.0;  ///< area of what is visible, and of all in view
};

/// The part of the horizontal plane through the eye that is visible. A radial that nothing blocks ends at
/// max_distance, or where it leaves the box around cloud, mesh, terrain and eye.
struct Isovist {
  double area = 0.0;
  double mean = 0.0, max = 0.0, deviation = 0.0;  ///< of the lengths of the radials
  double open = 0.0;                              ///< share of the radials that nothing blocks
};

/// Lengths are in the unit of the cloud. Points that block nothing (OccluderOptions::counts) are left out.
struct ObserverSummary {
  std::uint64_t visible_points = 0;
  BandSummary area;                 ///< over all distances
  std::vector<BandSummary> bands;   ///< one more than SummaryOptions::bands
  std::optional<Spread> distances;  ///< of the visible surface; empty: nothing is visible
  std::vector<double> class_areas;  ///< visible, by class; empty without classes
  std::optional<double> relief;     ///< standard deviation of z of the visible ground (classes 2, 9, 11)
  std::optional<double> diversity;  ///< Shannon index, -sum of p ln p, over the areas of the classes
  std::optional<Isovist> isovist;   ///< empty if the horizontal lies outside the field of view
  double volume = 0.0;              ///< visible part of that box, up to max_distance
  std::optional<Spread> horizon;    ///< elevations in degrees, to 0.1, azimuths without horizon left out
  SkyShares sky;                    ///< in all directions, whatever the field of view

  double ground_area() const;
};

/// Summarizes what each observer sees. The area of a point is pi s^2 / 8, with s the distance to its 8th
/// neighbour: the circle holds 8 others on average if points are distributed at random. On a regular grid
/// the area is a fifth too small, and at an edge of the surface up to twice too large. Cost:
/// point_visibility()'s, and per observer some 10^5 to 10^6 lines for horizon, isovist and sky. Memory:
/// 17 B per point and 16 B per visible point. Errors: those of point_visibility(), horizon() and
/// sky_shares(); bands out of order.
std::vector<ObserverSummary> summarize(const Occluders& occluders, std::span<const Observer> observers,
                                       const SummaryOptions& options);

/// A summary as a row of named values: `name`, `x`, `y`, `z` of the eye, and the numbers of
/// tools/manuals/visibility_summary.txt; null where there is no value. `bands`: as SummaryOptions; `classes`:
/// those of the cloud.
Row summary_row(const ObserverSummary& summary, const Observer& observer, std::span<const double> bands,
                const std::bitset<256>& classes);

/// Writes a row for each observer; cells without a value are empty. CSV, JSON with the list
/// `observers`, or GeoJSON with points. Coordinates, returned value and Errors as write_positions(). Requires
/// as many observers as summaries.
bool write_summaries(std::span<const ObserverSummary> summaries, std::span<const Observer> observers,
                     const SummaryOptions& options, RowForm form, const RowFileHead& head,
                     const ToLonLat& to_lon_lat, const std::filesystem::path& file, bool overwrite);

}  // namespace alidade::visibility
