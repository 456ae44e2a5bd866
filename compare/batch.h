// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compare/comparison.h"
#include "compare/pair_list.h"
#include "compare/verdict.h"

namespace alidade::compare {

struct BatchOptions {
  ComparisonOptions comparison;
  std::vector<Threshold> fail_above, warn_above;
  bool keep_thumbnails = false;   ///< for the summary
  std::filesystem::path reports;  ///< folder for a report of each pair, made if absent; empty: none
  image::ImagePacking packing = image::ImagePacking::automatic;
  bool overwrite = false;
  std::vector<std::filesystem::path> kept;  ///< files beside the images that reports must not replace
};

/// The outcome of a pair.
struct PairOutcome {
  ImagePair pair;
  std::optional<Comparison> comparison;  ///< without images; empty: see `error`
  Verdict verdict, warnings;
  std::string error;             ///< why there is no comparison
  bool sizes_differ = false;     ///< that is the error
  std::filesystem::path report;  ///< in the folder of reports; empty: none was requested
  std::vector<std::pair<std::string, std::string>> thumbnails;  ///< name and address (data_url())

  bool pass() const { return error.empty() && verdict.pass(); }
};

/// Compares pairs on all threads; a pair that cannot be compared, also for lack of memory, spoils no other.
/// The worst comes first: errors, then failures, then passes; among them the largest FLIP (without colours:
/// the largest mean error of depth), then by name. Progress counts pairs, and is called several times for
/// each so that it can cancel. Errors: reports that cannot be written, or would replace an image or a kept
/// file; Cancelled. Memory: that of one pair for each thread, but of at most eight pairs and, unless a single
/// one is larger, of 32 million pixels (about 3 GB) at a time.
std::vector<PairOutcome> compare_pairs(const std::vector<ImagePair>& pairs, const BatchOptions& options,
                                       const Progress& progress = {});

}  // namespace alidade::compare
