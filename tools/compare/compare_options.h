// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "compare/comparison.h"
#include "compare/verdict.h"
#include "tools/options.h"

namespace alidade {

/// Points behind regions of change: the cloud that a picture was made of, and where its points go.
struct RegionPointsRequest {
  std::filesystem::path cloud, output;
  bool partial = false;  ///< ReadOptions::partial, as when the picture was made
};

/// What the command line of `alidade compare` asks for.
struct CompareRequest {
  std::filesystem::path reference, test;  ///< two files or two folders
  std::filesystem::path pairs;            ///< or a table
  ComparisonOptions comparison;
  std::vector<Threshold> fail_above, warn_above;
  bool idiff_codes = false, json = false;
  std::filesystem::path report, reports;
  std::optional<PicturePacking> packing;
  std::filesystem::path color_map, flip_map, depth_map;
  RegionPointsRequest reference_points, test_points;
  bool overwrite = false;
  std::optional<int> threads;
  VerbosityOptions verbosity;

  bool has_maps() const { return !color_map.empty() || !flip_map.empty() || !depth_map.empty(); }
  bool has_points() const { return !reference_points.output.empty() || !test_points.output.empty(); }
};

/// Declares the options.
void add_compare_options(CLI::App& command, CompareRequest& request);

/// Files that the run writes, all of them.
std::vector<std::filesystem::path> outputs_of(const CompareRequest& request);

}  // namespace alidade
