// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <utility>

#include "cloud/cloud_reader.h"
#include "cloud/las/las_columns.h"
#include "cloud/las/las_header.h"
#include "cloud/las/las_records.h"
#include "cloud/laz/laz_layout.h"
#include "cloud/laz/laz_points.h"
#include "cloud/rows.h"
#include "cloud/table_reader.h"

namespace alidade {
namespace {

constexpr std::size_t k_block_bytes = 1 << 20;

/// Appends unpacked records to the cloud.
class CloudRows final : public LazSink {
 public:
  CloudRows(const LasColumns& columns, const LasColumns::Choice& choice, std::size_t point_size,
            PointCloud& cloud, const CloudPieces& pieces)
      : columns_(columns), choice_(choice), point_size_(point_size), cloud_(cloud), pieces_(pieces) {}

  void make_room(std::uint64_t count) override {
    // All `count` rows are appended, even beyond the room of the piece.
    if (room_in_piece(cloud_, choice_.kept, count, pieces_) < count && cloud_.size() > 0)
      pieces_.take(cloud_);
    shift_ = static_cast<std::int64_t>(cloud_.size()) - static_cast<std::int64_t>(count_);
    count_ += count;
    append_rows(cloud_, choice_.kept, static_cast<std::size_t>(count));
  }
  bool has_values(std::uint64_t count) override {
    return recalls(pieces_, cloud_, static_cast<std::size_t>(count));
  }
  void take(const std::byte* records, std::size_t count, std::uint64_t first_row) override {
    const std::int64_t row = static_cast<std::int64_t>(first_row) + shift_;
    columns_.take({records, point_size_, count, static_cast<std::size_t>(row)}, choice_, cloud_);
  }

  /// Rows made so far.
  std::uint64_t count() const { return count_; }

 private:
  const LasColumns& columns_;
  const LasColumns::Choice& choice_;
  std::size_t point_size_;
  PointCloud& cloud_;
  const CloudPieces& pieces_;
  std::uint64_t count_ = 0;
  std::int64_t shift_ = 0;  ///< from rows of the file to those of the cloud
};

class LasReader final : public CloudReader {
 public:
  LasReader(InputFile file, Damage damage)
      : file_(std::move(file)),
        damage_(damage),
        header_(read_las_header(file_, warnings_, damage)),
        records_(read_las_records(file_, header_, warnings_, damage)),
        laz_(read_packing(file_, header_, records_, damage)),
        columns_(file_.name(), header_, records_.extra_dimensions) {
    if (!laz_ && header_.extended_record_count == 0)
      reject_text_transfer(file_, header_.points_offset, header_.points_end());
    facts_ = {.file = about(),
              .bytes = file_.size(),
              .attributes = columns_.attributes(),
              .lattice = header_.lattice,
              .point_count = header_.point_count,
              .crs = std::move(records_.crs),
              .gps_time_is_standard = (header_.global_encoding & k_las_gps_time_is_standard) != 0,
              .project_id = header_.project_id,
              .file_source_id = header_.file_source_id,
              .box = widened_header_box(header_.bounds, header_.lattice)};
  }

  FileRead read(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                const Progress& progress) override {
    cloud.warnings.insert(cloud.warnings.end(), warnings_.begin(), warnings_.end());
    cloud.records.insert(cloud.records.end(), records_.others.begin(), records_.others.end());
    FileRead done = read_rows(header_.point_count);
    if (header_.point_count > 0) {
      const LasColumns::Choice choice = columns_.choose(wanted, cloud);
      if (laz_) {
        CloudRows rows(columns_, choice, header_.point_size, cloud, pieces);
        LazPoints points(file_, header_, *laz_, damage_);
        cloud.warnings.insert(cloud.warnings.end(), points.warnings().begin(), points.warnings().end());
        done.lost = points.read(layers_of(choice.kept), rows, progress);
        done.files.front().point_count = rows.count();
      } else {
        read_plain(choice, cloud, pieces, progress);
      }
    }
    if (header_.lost_count > 0)
      done.lost = {{.count = header_.lost_count,
                    .location = fmt::format("byte {}", file_.size()),
                    .problem = "truncated file: it ends before its last point"}};
    return done;
  }

  void rest() override { file_.rest(); }

 private:
  CloudFile about() const {
    CloudFile file;
    file.path = file_.name();
    file.format = !laz_ ? "LAS" : records_.copc_info ? "COPC" : "LAZ";
    file.version = fmt::format("1.{}", header_.version_minor);
    file.point_format = header_.point_format;
    file.point_count = header_.point_count;
    if (!header_.bounds.empty()) file.stated_bounds = header_.bounds;
    file.software = header_.generating_software;
    file.system_identifier = header_.system_identifier;
    if (header_.creation_year > 0 && header_.creation_day > 0 && header_.creation_day <= 366) {
      using namespace std::chrono;
      const year_month_day day =
          sys_days(year(header_.creation_year) / January / 1) + days(header_.creation_day - 1);
      file.created = fmt::format("{:04}-{:02}-{:02}", static_cast<int>(day.year()),
                                 static_cast<unsigned>(day.month()), static_cast<unsigned>(day.day()));
    }
    return file;
  }

  void read_plain(const LasColumns::Choice& choice, PointCloud& cloud, const CloudPieces& pieces,
                  const Progress& progress) {
    const std::size_t point_size = header_.point_size;
    const std::size_t step = std::max<std::size_t>(k_block_bytes / point_size, 1);
    std::uint64_t offset = header_.points_offset;
    while (offset < header_.points_end()) {
      const std::uint64_t left = (header_.points_end() - offset) / point_size;
      const std::size_t count =
          room_in_piece(cloud, choice.kept, std::min<std::uint64_t>(step, left), pieces);
      const std::size_t first = cloud.size();
      append_rows(cloud, choice.kept, count);
      if (!recalls(pieces, cloud, count))
        columns_.take({file_.view(offset, count * point_size).data(), point_size, count, first}, choice,
                      cloud);
      offset += count * point_size;
      report(progress, offset, file_.size());
    }
  }

  InputFile file_;
  Damage damage_;
  std::vector<std::string> warnings_;
  LasHeader header_;
  LasRecords records_;
  std::optional<LazLayout> laz_;
  LasColumns columns_;
};

}  // namespace

std::unique_ptr<CloudReader> open_las(InputFile file, Damage damage) {
  return std::make_unique<LasReader>(std::move(file), damage);
}

}  // namespace alidade
