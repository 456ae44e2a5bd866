// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>

#include "base/progress.h"
#include "simulation/scan.h"

namespace alidade {

struct GenerateOptions {
  std::uint64_t point_count = 2'000'000;
  std::uint64_t seed = 1;
  bool overwrite = false;  ///< otherwise an existing file is an Error
  Progress progress;       ///< in points
};

/// The stations and flight lines of the sample scan of courtyard().
ScanOptions courtyard_scan(std::uint64_t point_count, std::uint64_t seed);

/// Scans courtyard() into a LAS 1.4 file, in bounded memory. The same bytes for the same count and seed,
/// everywhere. Errors: the file exists or cannot be written. Throws Cancelled if asked to stop; the file then
/// does not appear.
void generate_courtyard(const std::filesystem::path& path, const GenerateOptions& options = {});

}  // namespace alidade
