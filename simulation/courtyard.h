// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>

#include "base/progress.h"
#include "simulation/scan.h"
#include "simulation/site.h"

namespace alidade::simulation {

/// The sample site: a courtyard between four wings, in UTM-like coordinates. It is always the same, down
/// to the last leaf. Its own frame has its origin at world (690000, 5325000, 600): x east, y north, the
/// yard's paving at z = 0; the ground beyond the buildings varies by up to a metre. All of it lies
/// within |x| <= 62, |y| <= 54.
///
///      y                          garden, trees
///      26 ┌─────────────────────────────────────────────────┐
///         │ north wing, three storeys, dormers, ridge 12.4  │
///    16.5 ├──────┬────flower bed───┤door├───flower bed──┬───┤
///         │ west │ tree on a lawn     │   tree on a lawn│ e │
///         │ wing,│                    │                 │ a │        neighbour's
///       0 │ ar-  │  bench         fountain (0,-0.5)     │ s │        house
///         │ cade │            four benches round it     │ t │
///         │      │ tree on a lawn                       │   │
///         │      │ flowers     │          cars          │   │
///   -17.5 │      ├────────────gate──────────────────────┤   │
///         │      │ south wing, gateway at x = -5        │   │
///     -26 └──────┴──────────────────────────────────────┴───┘
///                pavement with trees and lamps
///     -36   ═════════════ street, a parked car ══════════════
///     -45   houses across the street
///   x:   -33   -24.5         -5   0                  24.5  33
///
/// A view to show: from (23, -15.2, 6.8) to (-5, 2.5, 1.2), vertical field of view 56 degrees, image
/// 3:2, the sun at azimuth 150, elevation 40: over cars and fountain to arcade and main house. Cost:
/// about a tenth of a second.
Site courtyard();

struct GenerateOptions {
  std::uint64_t point_count = 2'000'000;
  std::uint64_t seed = 1;
  bool overwrite = false;  ///< otherwise an existing file is an Error
  Progress progress{};     ///< in points
};

/// The stations and flight lines of the sample scan of courtyard().
ScanOptions courtyard_scan(std::uint64_t point_count, std::uint64_t seed);

/// Scans courtyard() into a LAS 1.4 file, in bounded memory. The same count and seed give the same bytes on
/// every machine. Errors: the file exists or cannot be written. Throws Cancelled if `progress` ends the
/// scan; there is no file then.
void generate_courtyard(const std::filesystem::path& path, const GenerateOptions& options = {});

}  // namespace alidade::simulation
