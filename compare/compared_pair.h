// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "compare/comparison.h"

namespace alidade {

/// Two pictures of one size and what counts in them.
struct ComparedPair {
  ComparedImage reference, test;
  ImageMask mask;

  bool have_colors() const { return !reference.color.empty() && !test.color.empty(); }
  bool have_depth() const { return !reference.depth.empty() && !test.depth.empty(); }
};

/// Reads both, resizes the test, masks and crops as the options say. `remarks` gets what makes them differ
/// before any pixel is looked at. Errors: those of compare_files() that concern files, sizes, masks and
/// crops.
ComparedPair read_compared_pair(const std::filesystem::path& reference, const std::filesystem::path& test,
                                const ComparisonOptions& options, std::vector<std::string>& remarks);

}  // namespace alidade
