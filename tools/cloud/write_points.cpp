// SPDX-License-Identifier: MIT
#include "tools/cloud/write_points.h"

#include <fmt/format.h>
#include <algorithm>

#include "base/words.h"
#include "cloud/las/write_las.h"
#include "cloud/ply/write_ply.h"
#include "octree/tree_walk.h"

namespace alidade::tools {
namespace {

constexpr std::size_t k_rows_at_once = 1 << 17;

/// Some rows of a cloud with their results.
class Rows {
 public:
  Rows(const IndexedCloud& cloud, const std::vector<ResultColumn>& results)
      : columns_(cloud.columns()), results_(results), positions_(positions_in_order(cloud.octree.view())) {
    batch_.lattice = cloud.octree.lattice();
    std::erase_if(columns_.extra_dimensions, [&](const ExtraColumn& column) {
      const bool is_replaced = std::ranges::any_of(results_, [&](const ResultColumn& result) {
        return result.description.name == column.description.name;
      });
      if (is_replaced) replaced_.push_back(column.description.name);
      return is_replaced;
    });
    for (const ExtraColumn& column : columns_.extra_dimensions)
      batch_.extra_dimensions.push_back(column.description);
    for (const ResultColumn& result : results_) batch_.extra_dimensions.push_back(result.description);
  }

  std::size_t size() const { return positions_.size(); }
  AttributeSet attributes() const { return columns_.attributes() | Attribute::extra_dimensions; }
  /// Without values.
  const std::vector<ExtraDimension>& dimensions() const { return batch_.extra_dimensions; }
  /// Names of the cloud's own dimensions that are left out.
  const std::vector<std::string>& replaced() const { return replaced_; }

  /// Valid until the next call.
  const PointCloud& rows(std::size_t first, std::size_t count) {
    batch_.positions.assign(positions_.begin() + static_cast<std::ptrdiff_t>(first),
                            positions_.begin() + static_cast<std::ptrdiff_t>(first + count));
    for_each_column(batch_, columns_, [&](Attribute, auto& column, const auto& all) {
      if (all.empty()) return;
      const auto some = all.subspan(first, count);
      column.assign(some.begin(), some.end());
    });
    auto dimension = batch_.extra_dimensions.begin();
    for (const ExtraColumn& column : columns_.extra_dimensions) {
      const auto bytes = static_cast<std::size_t>(column.description.byte_count);
      const auto some = column.values.subspan(first * bytes, count * bytes);
      (dimension++)->values.assign(some.begin(), some.end());
    }
    for (const ResultColumn& result : results_) {
      dimension->values.resize(count * static_cast<std::size_t>(result.description.byte_count));
      result.fill(first, count, dimension->values.data());
      ++dimension;
    }
    return batch_;
  }

 private:
  AttributeColumns columns_;  ///< without those that are left out
  const std::vector<ResultColumn>& results_;
  std::vector<LatticePosition> positions_;
  std::vector<std::string> replaced_;
  PointCloud batch_;
};

void write_las_rows(const std::filesystem::path& file, const IndexedCloud& cloud, Rows& rows, bool overwrite,
                    const Progress& progress) {
  PointCloud like = description_of(cloud);
  like.extra_dimensions = rows.dimensions();
  LasWriter writer(file, like, rows.attributes(), {.overwrite = overwrite});
  for (std::size_t first = 0; first < rows.size(); first += k_rows_at_once) {
    const std::size_t count = std::min(k_rows_at_once, rows.size() - first);
    writer.write(rows.rows(first, count));
    report(progress, first + count, rows.size());
  }
  writer.finish();
}

}  // namespace

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
  if (!has_extension(file, {".las", ".laz", ".ply"}))
    throw file_error(file, "unknown output format", "the extension .las, .laz or .ply");
}

void write_points(const std::filesystem::path& file, const IndexedCloud& cloud,
                  const std::vector<ResultColumn>& results, bool overwrite, Verbosity verbosity) {
  check_points_name(file);
  Rows rows(cloud, results);
  if (verbosity != Verbosity::quiet) {
    for (const std::string& name : rows.replaced())
      say_warning(fmt::format("{}: replacing the cloud's {}", file.string(), name));
  }
  ProgressLine line("writing", "points", verbosity);
  if (file_extension(file) != ".ply") {
    write_las_rows(file, cloud, rows, overwrite, line.callback());
  } else {
    const PlyPieces pieces = [&rows](std::size_t first) -> const PointCloud& {
      return rows.rows(first, std::min(k_rows_at_once, rows.size() - first));
    };
    write_ply(file, rows.size(), pieces, {.overwrite = overwrite, .progress = line.callback()});
  }
  line.finish();
}

}  // namespace alidade::tools
