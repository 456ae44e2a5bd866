// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
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

/// Files by what is to be said of them, in the order of the files. What many have in common is one sentence:
/// "a.las and 99 more files: ...".
class Remarks {
 public:
  void add(const std::string& remark, const std::string& file);
  /// Appends the sentences.
  void write(std::vector<std::string>& warnings) const;

 private:
  std::vector<std::pair<std::string, SomeFiles>> remarks_;
};

/// A file of a cloud that is still to be read.
struct CloudSource {
  FileFacts facts{};
  std::unique_ptr<CloudReader> reader{};  ///< null: only the statements of a catalog are known
  CoordinateSurvey survey{};              ///< of files without a lattice
  bool is_skipped = false;                ///< no point of it is needed

  bool has_lattice() const { return facts.lattice.has_value(); }
  std::string name() const { return facts.file.path.string(); }
  std::uint64_t work() const { return is_skipped ? 0 : std::max(facts.bytes, facts.work); }
  std::uint64_t point_count() const {
    return has_lattice() ? facts.point_count.value_or(0) : survey.finite_count;
  }
  /// Packed points rarely take less than a byte each: of more, memory is taken once they are unpacked.
  std::uint64_t least_points() const { return std::min(point_count(), facts.bytes); }
};

/// Gives a cloud what its files have in common, by the rules of read_cloud(): the lattice (joined_lattice());
/// the reference system of the first file that states one; the facts of the first file, and the kind of GPS
/// times of the first that has times. Warns of the files that differ.
///
/// Errors: a file without a lattice is too far away for that of the others; a file with points states another
/// reference system (compare_crs()), where the message names a file of the minority; a file states none
/// although heights of others are converted.
void join_facts(std::span<const CloudSource> sources, AttributeSet wanted, PointCloud& cloud);

/// Whether the points of a file with a lattice of its own are rounded to this one.
bool is_rounded(const CloudSource& source, const Lattice& lattice);

/// Warns of files that are given more than once, under any names, and of LAS files that look like copies of
/// others, by PointCloud::files.
void warn_of_twins(const CloudInputs& inputs, PointCloud& cloud);

}  // namespace alidade
