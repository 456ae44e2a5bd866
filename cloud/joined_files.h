// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "cloud/cloud_source.h"
#include "cloud/point_cloud.h"

// What is to be said about files that were joined to one cloud. What many files have in common is one
// sentence: "a.las and 99 more files: ...". Each function appends to PointCloud::warnings.

namespace alidade {

/// What one file gave to the cloud.
struct GivenRows {
  std::string file_name;
  std::uint64_t point_count = 0;
  AttributeSet attributes;
};

/// Coordinates of a file without a lattice that are rounded coarsely; the rule stands at read_cloud().
void warn_of_rounding(const CloudSource& source, PointCloud& cloud);

/// Attributes, of those that the cloud has, that were filled with zeros.
void warn_of_gaps(std::span<const GivenRows> given, AttributeSet present, std::vector<std::string>& warnings);

/// Files that state no reference system beside others that do.
void warn_of_missing_crs(std::span<const CloudSource> sources, PointCloud& cloud);

/// Files that state the reference system in a way that cannot be compared with the cloud's.
void warn_of_other_crs(std::span<const CloudSource> sources, PointCloud& cloud);

/// What a damaged file does not give any more, which is also counted in the first of `files`, its own.
void warn_of_losses(const CloudReader& reader, std::vector<CloudFile>& files, PointCloud& cloud);

/// Files that are given more than once, under whatever names.
void warn_of_twins(std::span<const std::filesystem::path> files, PointCloud& cloud);

}  // namespace alidade
