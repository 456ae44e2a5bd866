// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "compare/batch.h"
#include "compare/pair_list.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"

namespace alidade::jobs {

/// Points behind regions of change: the cloud that an image was made of, and the file for them.
struct RegionPointsRequest {
  std::filesystem::path cloud, output;
};

/// Two images, or many pairs of images. Without outputs nothing is written.
struct CompareRequest : compare::BatchOptions {
  std::filesystem::path reference, test;                                ///< two files or two folders
  std::filesystem::path pairs;                                          ///< or a table
  std::filesystem::path report;                                         ///< of a pair, or the summary of many
  std::filesystem::path color_map, flip_map, depth_map, agreement_map;  ///< of a single pair
  RegionPointsRequest reference_points, test_points;                    ///< of a single pair
  bool partial = false;  ///< damaged clouds are read in part: ReadOptions::partial
};

/// Declares all fields. `add_answers` declares those of whoever shows the result, where the manual has them.
void add_compare_fields(
    const Fields& fields, CompareRequest& request, const std::function<void()>& add_answers = [] {});

struct CheckedCompare : CompareRequest {
  bool is_batch = false;  ///< many pairs are requested: a table, or folders
  std::vector<compare::ImagePair> image_pairs{};
};
using ComparePlan = Plan<CheckedCompare>;

/// Checks all that can be checked before pixels are read. Errors: nothing to compare; fields that exclude or
/// require each other; those of compare::pairs_of_folders() and compare::read_pairs(); outputs that cannot be
/// written, or would replace an input.
ComparePlan plan(const CompareRequest& request);

/// The figures of each pair, and whether it passes, in the order of compare::compare_pairs().
using CompareResult = std::vector<compare::PairOutcome>;

/// Compares the pairs, and writes reports, maps and points where the request has outputs; notes what limits
/// the meaning of the figures, and warns of thresholds in `warn_above`. Errors: for a single pair those of
/// compare::compare_files() and compare::judge(), maps that these images do not have, and clouds that they
/// were not made of, all before a file is written; those of compare::compare_pairs() for many; Cancelled.
/// Memory: that of these functions, and the clouds of points.
CompareResult run(const ComparePlan& plan, Listener& listener);

}  // namespace alidade::jobs
