// SPDX-License-Identifier: MIT
#include "jobs/write_points.h"

#include <fmt/format.h>
#include <algorithm>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/words.h"
#include "cloud/las/write_las.h"
#include "cloud/ply/write_ply.h"
#include "cloud/rows.h"
#include "cloud/text/write_text.h"
#include "jobs/outputs.h"
#include "octree/tree_walk.h"

namespace alidade::jobs {
namespace {

constexpr std::size_t k_rows_at_once = 1 << 17;

/// The attribute columns of a cloud without those that results replace, whose names are appended to
/// `replaced`.
AttributeColumns kept_columns(const CloudResults& cloud, std::vector<std::string>& replaced) {
  AttributeColumns columns = cloud.cloud.columns();
  if (!cloud.colors.empty()) columns.colors = cloud.colors;
  std::erase_if(columns.extra_dimensions, [&](const ExtraColumn& column) {
    const bool is_replaced = std::ranges::any_of(cloud.results, [&](const ResultColumn& result) {
      return result.description.name == column.description.name;
    });
    if (is_replaced) replaced.push_back(column.description.name);
    return is_replaced;
  });
  return columns;
}

/// What all rows of a file share.
struct RowLayout {
  PointCloud like;  ///< with the extra dimensions, without values
  AttributeSet attributes = Attribute::extra_dimensions;
};

/// The rows of one cloud with their results.
class Rows {
 public:
  /// Adds what the cloud has to `layout`, which must outlive the rows.
  Rows(const CloudResults& cloud, RowLayout& layout)
      : cloud_(cloud), columns_(kept_columns(cloud, replaced_)), layout_(layout) {
    layout.attributes = layout.attributes | columns_.attributes();
    std::vector<ExtraDimension> own;
    for (const ExtraColumn& column : columns_.extra_dimensions) own.push_back(column.description);
    for (const ResultColumn& result : cloud.results) own.push_back(result.description);
    for (std::size_t i = 0; i < own.size(); ++i)
      dimensions_.push_back(find_extra_dimension(layout.like, own[i], occurrence_of(own, i)));
  }

  std::size_t size() const { return cloud_.cloud.octree.size(); }
  /// Names of the cloud's own dimensions that are left out.
  const std::vector<std::string>& replaced() const { return replaced_; }

  /// Rows in the layout, which is complete. Valid until the next call.
  const PointCloud& rows(std::size_t first, std::size_t count) {
    if (first == 0) start();
    take_positions(first, count);
    for_each_column(batch_, columns_, [&](Attribute attribute, auto& column, const auto& all) {
      if (!layout_.attributes.contains(attribute)) return;
      column.assign(count, {});
      if (!all.empty()) std::ranges::copy(all.subspan(first, count), column.begin());
    });
    auto dimension = dimensions_.begin();
    for (const ExtraColumn& column : columns_.extra_dimensions) {
      const auto bytes = static_cast<std::size_t>(column.description.byte_count);
      const auto some = column.values.subspan(first * bytes, count * bytes);
      values_of(*dimension++).assign(some.begin(), some.end());
    }
    for (const ResultColumn& result : cloud_.results) {
      std::vector<std::uint8_t>& values = values_of(*dimension++);
      values.resize(count * static_cast<std::size_t>(result.description.byte_count));
      result.fill(first, count, values.data());
    }
    return batch_;
  }

 private:
  void start() {
    const Octree& octree = cloud_.cloud.octree;
    positions_ = HugeArray<LatticePosition>(octree.size(), octree.scratch());
    put_positions(octree.view(), positions_.data());
    batch_.lattice = layout_.like.lattice;
    batch_.extra_dimensions = layout_.like.extra_dimensions;
  }

  std::vector<std::uint8_t>& values_of(std::size_t dimension) {
    return batch_.extra_dimensions[dimension].values;
  }

  void take_positions(std::size_t first, std::size_t count) {
    const Lattice& own = cloud_.cloud.octree.lattice();
    batch_.positions.assign(positions_.data() + first, positions_.data() + first + count);
    for (ExtraDimension& dimension : batch_.extra_dimensions)
      dimension.values.assign(count * static_cast<std::size_t>(dimension.byte_count), 0);
    if (own == batch_.lattice) return;
    for (LatticePosition& position : batch_.positions) {
      const auto moved = to_lattice(batch_.lattice, to_world(own, position));
      if (!moved) {
        const std::vector<CloudFile>& files = cloud_.cloud.cloud.files;
        throw file_error(files.empty() ? "" : files.front().path.string(),
                         "a point lies outside the bounds of its cloud", "an intact index file");
      }
      position = *moved;
    }
  }

  const CloudResults& cloud_;
  std::vector<std::string> replaced_;
  AttributeColumns columns_;  ///< without those that are left out
  const RowLayout& layout_;
  std::vector<std::size_t> dimensions_;  ///< index in the layout of each of its own and of its results
  HugeArray<LatticePosition> positions_;
  PointCloud batch_;
};

Lattice common_lattice(std::span<const CloudResults> clouds) {
  std::vector<Lattice> lattices;
  Bounds bounds;
  for (const CloudResults& cloud : clouds) {
    lattices.push_back(cloud.cloud.octree.lattice());
    bounds.grow(cloud.cloud.octree.bounds());
  }
  return joined_lattice(lattices, bounds);
}

/// All rows of all clouds.
class AllRows {
 public:
  explicit AllRows(std::span<const CloudResults> clouds) {
    layout_.like = description_of(clouds.front().cloud);
    layout_.like.lattice = common_lattice(clouds);
    for (const CloudResults& cloud : clouds) {
      if (layout_.like.crs.empty()) layout_.like.crs = cloud.cloud.cloud.crs;
      size_ += clouds_.emplace_back(cloud, layout_).size();
    }
  }
  AllRows(const AllRows&) = delete;
  AllRows& operator=(const AllRows&) = delete;

  std::size_t size() const { return size_; }
  const RowLayout& layout() const { return layout_; }
  std::span<const Rows> clouds() const { return clouds_; }

  /// Some rows from `first` on, all of one cloud. Valid until the next call.
  const PointCloud& from(std::size_t first) {
    auto cloud = clouds_.begin();
    for (; first >= cloud->size(); ++cloud) first -= cloud->size();
    return cloud->rows(first, std::min(k_rows_at_once, cloud->size() - first));
  }

 private:
  RowLayout layout_;
  std::vector<Rows> clouds_;
  std::size_t size_ = 0;
};

}  // namespace

void write_rows(const std::filesystem::path& file, const PointRows& rows, bool overwrite,
                std::optional<std::uint64_t> memory, Listener& listener) {
  in_stage(listener, "writing", "points", [&](const Progress& progress) {
    if (has_extension(file, {".ply"}))
      return write_ply(file, rows.count, rows.from, {.overwrite = overwrite, .progress = progress});
    if (has_extension(file, {".csv", ".xyz"}))
      return write_text(
          file, rows.count, rows.from,
          {.coordinates_alone = has_extension(file, {".xyz"}), .overwrite = overwrite, .progress = progress});
    LasWriteOptions options{.overwrite = overwrite,
                            .progress = progress,
                            .expected_points = rows.count,
                            .warn = [&listener](const std::string& text) { listener.warn(text); }};
    options.memory = memory.value_or(options.memory);
    LasWriter writer(file, rows.like, rows.attributes, options);
    for (std::size_t first = 0; first < rows.count;) {
      const PointCloud& some = rows.from(first);
      writer.write(some);
      first += some.size();
    }
    writer.finish();
  });
}

PointCloud description_of(const IndexedCloud& cloud) {
  PointCloud description;
  description.lattice = cloud.octree.lattice();
  description.crs = cloud.cloud.crs;
  description.records = cloud.index ? cloud.index->records() : cloud.cloud.records;
  description.gps_time_is_standard = cloud.cloud.gps_time_is_standard;
  description.project_id = cloud.cloud.project_id;
  description.file_source_id = cloud.cloud.file_source_id;
  return description;
}

void check_points_name(const std::filesystem::path& file) {
  check_extension(file, {".las", ".laz", ".ply"});
}

void write_points(const std::filesystem::path& file, const IndexedCloud& cloud,
                  const std::vector<ResultColumn>& results, bool overwrite,
                  std::optional<std::uint64_t> memory, Listener& listener) {
  const CloudResults only{cloud, results};
  write_points(file, {&only, 1}, overwrite, memory, listener);
}

void write_points(const std::filesystem::path& file, std::span<const CloudResults> clouds, bool overwrite,
                  std::optional<std::uint64_t> memory, Listener& listener) {
  check_points_name(file);
  AllRows rows(clouds);
  for (const Rows& cloud : rows.clouds())
    for (const std::string& name : cloud.replaced())
      listener.warn(fmt::format("{}: replacing the cloud's {}", file.string(), name));
  const PointPieces from = [&rows](std::size_t first) -> const PointCloud& { return rows.from(first); };
  write_rows(file, {rows.layout().like, rows.layout().attributes, rows.size(), from}, overwrite, memory,
             listener);
}

}  // namespace alidade::jobs
