// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "cloud/point_cloud.h"

namespace alidade {

/// Bytes that the position, these attributes and the cloud's extra dimensions take for a point.
std::uint64_t bytes_per_point(const PointCloud& cloud, AttributeSet attributes);

/// Appends `count` points of zeros to the positions and to every column that is present or in `filled`. A
/// column of `filled` that is not there yet first gets zeros for the earlier points. Extra dimensions are
/// made by find_extra_dimension(); those that exist grow here. Never takes more memory than the new size
/// needs: growing by small blocks is cheap only in columns with room reserved.
void append_rows(PointCloud& cloud, AttributeSet filled, std::size_t count);

/// Index of the cloud's extra dimension that means the same as `like`, made with zeros for all points if
/// missing. The values of `like` are ignored. If a file has several of one meaning, `occurrence` counts them
/// from 0.
std::size_t find_extra_dimension(PointCloud& cloud, const ExtraDimension& like, std::size_t occurrence = 0);

/// Whether two extra dimensions can share a column: equal in name, type, scale, offset and "no value" mark.
bool same_meaning(const ExtraDimension& a, const ExtraDimension& b);

/// How many of the dimensions before the i-th mean the same as that one: its `occurrence`. `description`
/// leads from an element to its ExtraDimension.
template <class Dimensions, class Description = std::identity>
std::size_t occurrence_of(const Dimensions& dimensions, std::size_t i, Description description = {}) {
  const auto same = [&](std::size_t other) {
    return same_meaning(std::invoke(description, dimensions[other]), std::invoke(description, dimensions[i]));
  };
  std::size_t count = 0;
  for (std::size_t other = 0; other < i; ++other) count += same(other) ? 1 : 0;
  return count;
}

/// The dimension without its values.
ExtraDimension description_of(const ExtraDimension& dimension);

/// Appends the points of `piece`, its records, scanner positions and warnings: the cloud is then as if the
/// reader that filled the piece had appended to it (CloudReader::read). Requires equal lattices. What the
/// cloud says of itself and its files stay. Memory: columns with room reserved are not moved.
void append_cloud(PointCloud& cloud, PointCloud&& piece);

/// Takes the points out of a cloud whose mark is 0; the others close up in the order they had, with all their
/// attributes; CloudFile::point_count follows. One mark per point. Memory: none. Cost: one pass over every
/// column.
void keep_rows(PointCloud& cloud, std::span<const std::uint8_t> marks);

/// Counts the points of each file that keep_rows() leaves, if the files account for all rows.
void count_points(std::vector<CloudFile>& files, std::span<const std::uint8_t> marks);

/// Keeps the first point and every `step`-th from there on: rows 0, step, 2 * step ... As keep_rows(); `step`
/// is at least 1.
void keep_every(PointCloud& cloud, std::uint64_t step);

/// Brings the rows of all attribute columns into another order: row i becomes what row order[i] was. Columns
/// that are absent stay absent; positions are left as they are. `order` holds every row once. Memory: one
/// column at a time.
void reorder_attributes(PointCloud& cloud, std::span<const std::uint32_t> order);

/// Point ids of the whole cloud for the rows of one that was read without the files outside a region
/// (ReadOptions::region): what the rows would be had these been read too. Order stays.
class RowIds {
 public:
  /// `files` are PointCloud::files.
  explicit RowIds(std::span<const CloudFile> files);

  /// Cost: that of a search among the skipped files; nothing without such files.
  std::uint64_t operator()(std::uint64_t row) const;

  std::size_t skipped_files() const { return skipped_files_; }

 private:
  struct Skip {
    std::uint64_t row;     ///< the first behind it
    std::uint64_t before;  ///< points skipped up to there
  };
  std::vector<Skip> skips_;
  std::size_t skipped_files_ = 0;
};

}  // namespace alidade
