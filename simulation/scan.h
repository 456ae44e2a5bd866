// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "base/progress.h"
#include "cloud/point_cloud.h"
#include "simulation/scanner.h"
#include "simulation/site.h"

namespace alidade {

struct ScanOptions {
  std::uint64_t point_count = 2'000'000;  ///< exactly as many points come out
  std::uint64_t seed = 1;                 ///< of the range noise
  std::vector<Station> stations;
  std::vector<FlightLine> flight_lines;  ///< REQUIRED: at least one, over the site
  double terrestrial_share = 0.65;       ///< of the points from the stations, about; 0 .. 1
  TerrestrialScanner terrestrial;
  DroneScanner drone;
};

/// Takes the next points of a scan. `batch` stands on the scan's lattice and is only valid during the call.
using PointSink = std::function<void(const PointCloud& batch)>;

/// A cloud without points that carries what all batches of a scan share: the lattice (1 mm, offset = the
/// site's origin, which must be whole metres) and the CRS (WGS 84 / UTM zone 32N). What LasWriter wants as
/// `like`.
PointCloud scan_header(const Site& site);

/// The columns every batch has: color, intensity, classification, returns, scan_angle, point_source_id,
/// gps_time.
AttributeSet scan_attributes();

/// Scans the site from every station, then along every flight line, and hands exactly `point_count` points to
/// `sink`, in batches of some ten thousand in a fixed order, from one thread at a time. Traces in parallel
/// (oneTBB). The points are the same on any number of threads and on any machine.
///
/// How the number comes out exact without cutting anything off: a coarse survey of each station tells the
/// share of its beams that meet something; from it one angular step for all stations is chosen that gives
/// about terrestrial_share of the points. The flight then sends as many beams as points are missing, spread
/// evenly over its lines; beams that miss the site are made up for by further passes, each as large as the
/// share of hits so far lets expect. (Surplus points are left out only if the stations alone should give more
/// than point_count, which takes a share of nearly 1 or a handful of points, and behind such further passes;
/// courtyard() needs none.)
///
/// Each point lies on its beam, off the surface by the range noise (a sum of eight uniform numbers, so never
/// beyond 5 standard deviations), rounded to the lattice. point_source_id counts stations, then lines, from
/// 1; gps_time increases.
///
/// Errors: no flight line, or one that is not level above the origin; a flight that meets nothing; a point
/// outside the lattice. Throws Cancelled if asked to stop. Cost: about a microsecond per point on two cores;
/// memory: some 20 MB.
void scan(const Site& site, const ScanOptions& options, const PointSink& sink, const Progress& progress = {});

}  // namespace alidade
