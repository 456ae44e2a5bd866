// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "cloud/cloud_reader.h"
#include "cloud/point_cloud.h"

namespace alidade {

/// The first of some files, and how many they are.
class SomeFiles {
 public:
  void add(const std::string& file);
  std::size_t count() const { return count_; }
  /// "a.las", "a.las and 1 more file", "a.las and 2 more files".
  std::string text() const;

 private:
  std::string first_;
  std::size_t count_ = 0;
};

/// A file of a cloud that is still to be read.
struct CloudSource {
  std::unique_ptr<CloudReader> reader;
  std::uint64_t bytes = 0;  ///< of the file
  std::uint64_t work = 0;   ///< of a pass: the bytes, or CloudReader::work()
  bool has_lattice = false;
  FileFacts facts{};
  CoordinateSurvey survey{};  ///< of files without a lattice
  bool is_skipped = false;    ///< lies outside ReadOptions::region
  bool is_open = true;        ///< false: only the statements of a catalog are known
  bool is_rounded = false;    ///< by warn_of_lattices()

  const std::filesystem::path& path() const { return reader->file().path; }
  std::uint64_t point_count() const {
    return has_lattice ? reader->point_count().value_or(0) : survey.finite_count;
  }
};

/// The lattice of the joined cloud, by the rules of read_cloud(): joined_lattice() of the files that have
/// one. Errors: a file without one is too far away for it.
Lattice common_lattice(const std::vector<CloudSource>& sources);

/// The coordinate reference system of the joined cloud: that of the first file that states one. Errors: a
/// file with points states a different one (compare_crs()), where the message names a file of the minority; a
/// file states none although heights of others are converted.
Crs common_crs(const std::vector<CloudSource>& sources);

/// Keeps one copy of the records that the tiles of a survey repeat. Repetitions within one file stay, as in
/// the file. Cost: that of sorting all records.
class JoinedRecords {
 public:
  /// The records must outlive this object, and may change only at their end during its life.
  explicit JoinedRecords(std::vector<VariableLengthRecord>& records)
      : records_(records), earlier_(Order{&records}) {}

  /// Removes those of the records from index `first` on, which one file has added, that an earlier file has.
  void join(std::size_t first);

 private:
  struct Order {
    const std::vector<VariableLengthRecord>* records;
    bool operator()(std::size_t a, std::size_t b) const;
  };

  std::vector<VariableLengthRecord>& records_;
  std::set<std::size_t, Order> earlier_;  ///< indices of the records of the files joined so far
};

// Warnings about files that were joined to one cloud. What many files have in common is one sentence: "a.las
// and 99 more files: ...". Each function appends to PointCloud::warnings.

/// The points and attributes that one file added to the cloud.
struct GivenRows {
  std::string file_name;
  std::uint64_t point_count = 0;
  AttributeSet attributes;
};

/// Warns of a file without a lattice whose coordinates are rounded coarsely, by the rule of read_cloud().
void warn_of_rounding(const CloudSource& source, PointCloud& cloud);

/// Reports how heights were converted (FileFacts::heights_note).
void warn_of_heights(std::span<const CloudSource> sources, PointCloud& cloud);

/// Warns of files whose lattice is not on that of the cloud, so that their coordinates are rounded.
void warn_of_lattices(std::span<CloudSource> sources, PointCloud& cloud);

/// Warns of attributes of the cloud that were filled with zeros.
void warn_of_gaps(std::span<const GivenRows> given, AttributeSet present, std::vector<std::string>& warnings);

/// Warns of files that state no reference system beside others that do.
void warn_of_missing_crs(std::span<const CloudSource> sources, PointCloud& cloud);

/// Warns of files whose reference system cannot be compared with the cloud's.
void warn_of_other_crs(std::span<const CloudSource> sources, PointCloud& cloud);

/// Warns of points of a damaged file that cannot be read, and counts them in the first of `files`, its own.
void warn_of_losses(const CloudReader& reader, std::vector<CloudFile>& files, PointCloud& cloud);

/// Warns of files that are given more than once, under any names, and of LAS files that look like copies of
/// others.
void warn_of_twins(const CloudInputs& inputs, PointCloud& cloud);

}  // namespace alidade
