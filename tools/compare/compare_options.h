// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "compare/comparison.h"
#include "compare/pair_list.h"
#include "compare/verdict.h"
#include "tools/options.h"

namespace alidade::tools {

/// Points behind regions of change: the cloud that an image was made of, and where its points go.
struct RegionPointsRequest {
  std::filesystem::path cloud, output;
};

/// The command line of `alidade compare`.
struct CompareRequest : RunRequest {
  std::filesystem::path reference, test;  ///< two files or two folders
  std::filesystem::path pairs;            ///< or a table
  compare::ComparisonOptions comparison;
  std::vector<compare::Threshold> fail_above, warn_above;
  bool idiff_codes = false, json = false;
  std::filesystem::path report, reports;
  std::optional<image::ImagePacking> packing;
  std::filesystem::path color_map, flip_map, depth_map, agreement_map;
  RegionPointsRequest reference_points, test_points;
  bool overwrite = false;

  bool has_maps() const {
    return !color_map.empty() || !flip_map.empty() || !depth_map.empty() || !agreement_map.empty();
  }
  bool has_points() const { return !reference_points.output.empty() || !test_points.output.empty(); }
};

/// Declares the options.
void add_compare_options(const Fields& command, CompareRequest& request);

// Checks of a request before pixels are read.

/// Whether many pairs of images are requested.
bool is_batch(const CompareRequest& request);

/// Errors that need no image: missing or surplus operands, options that exclude each other, outputs that
/// cannot be written or would replace an input.
void check_request(const CompareRequest& request);

/// Checks the outputs of a batch. Errors: the summary would replace one of its images.
void check_pairs(const CompareRequest& request, const std::vector<compare::ImagePair>& pairs);

}  // namespace alidade::tools
