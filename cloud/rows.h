// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "cloud/point_cloud.h"

namespace alidade {

/// Bytes per point of the position, these attributes and the cloud's extra dimensions.
std::uint64_t bytes_per_point(const PointCloud& cloud, AttributeSet attributes);

/// Appends `count` points of zeros to the positions and to every column that is present or in `filled`. A
/// column of `filled` that is not present yet first gets zeros for the earlier points. Extra dimensions are
/// made by find_extra_dimension(); existing ones grow here. Never takes more memory than the new size needs:
/// growing by small blocks is cheap only in columns with room reserved.
void append_rows(PointCloud& cloud, AttributeSet filled, std::size_t count);

/// Index of the cloud's extra dimension with the meaning of `like` (same_meaning()), which is made with zeros
/// for all points if missing. The values of `like` are ignored. If a file has several of one meaning,
/// `occurrence` counts them from 0.
std::size_t find_extra_dimension(PointCloud& cloud, const ExtraDimension& like, std::size_t occurrence = 0);

/// Whether two extra dimensions can share a column: equal in name, type, scale, offset and "no value" mark.
bool same_meaning(const ExtraDimension& a, const ExtraDimension& b);

/// How many of the dimensions before the i-th have its meaning: its `occurrence`. `description` returns the
/// ExtraDimension of an element.
template <class Dimensions, class Description = std::identity>
std::size_t occurrence_of(const Dimensions& dimensions, std::size_t i, Description description = {}) {
  const auto same = [&](std::size_t other) {
    return same_meaning(std::invoke(description, dimensions[other]), std::invoke(description, dimensions[i]));
  };
  std::size_t count = 0;
  for (std::size_t other = 0; other < i; ++other) count += same(other) ? 1 : 0;
  return count;
}

/// A copy of the dimension without its values.
ExtraDimension description_of(const ExtraDimension& dimension);

/// Appends the points of `piece`, its records, scanner positions and warnings: the cloud is then as if the
/// reader of the piece had appended to it (CloudReader::read()). Requires equal lattices. The cloud's other
/// facts and its files do not change. Memory: columns with room reserved are not moved.
void append_cloud(PointCloud& cloud, PointCloud&& piece);

/// Removes the points whose mark is 0 from a cloud. The others keep their order and attributes;
/// CloudFile::point_count is adapted. Requires one mark per point. Memory: none. Cost: one pass over every
/// column.
void keep_rows(PointCloud& cloud, std::span<const std::uint8_t> marks);

/// Sets the number of points of each file to that of the rows that keep_rows() keeps, if the files have all
/// rows of the cloud.
void count_points(std::vector<CloudFile>& files, std::span<const std::uint8_t> marks);

/// keep_rows() for the rows 0, step, 2 * step, ... Requires step >= 1.
void keep_every(PointCloud& cloud, std::uint64_t step);

/// Reorders the rows of all attribute columns: row i gets the values of row order[i]. Absent columns stay
/// absent, positions unchanged. Requires every row once in `order`. Memory: one column at a time.
void reorder_attributes(PointCloud& cloud, std::span<const std::uint32_t> order);

/// Point ids in the whole cloud for the rows of a cloud that was read without the files outside a region
/// (ReadOptions::region): the rows that the points would have if all files had been read. Keeps the order.
class RowIds {
 public:
  /// `files` are PointCloud::files.
  explicit RowIds(std::span<const CloudFile> files);

  /// The id of a row. Cost: that of a search among the skipped files, if any.
  std::uint64_t operator()(std::uint64_t row) const;

  std::size_t skipped_files() const { return skipped_files_; }

 private:
  struct Skip {
    std::uint64_t row;     ///< the first behind the skipped file
    std::uint64_t before;  ///< points skipped before that row
  };
  std::vector<Skip> skips_;
  std::size_t skipped_files_ = 0;
};

}  // namespace alidade
