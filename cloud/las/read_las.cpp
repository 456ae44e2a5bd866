// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "base/error.h"
#include "cloud/append_rows.h"
#include "cloud/cloud_reader.h"
#include "cloud/fit_lattice.h"
#include "cloud/las/las_header.h"
#include "cloud/las/las_records.h"
#include "cloud/las/read_las.h"
#include "cloud/laz/attribute_layers.h"
#include "cloud/laz/laz_points.h"

namespace alidade {
namespace {

constexpr std::size_t k_block_bytes = 1 << 20;

/// Puts unpacked records into the cloud, which they make longer.
class CloudRows final : public LazSink {
 public:
  CloudRows(const LasColumns& columns, const LasColumns::Choice& choice, std::size_t point_size,
            PointCloud& cloud, const CloudPieces& pieces)
      : columns_(columns), choice_(choice), point_size_(point_size), cloud_(cloud), pieces_(pieces) {}

  void make_room(std::uint64_t count) override {
    // As many are coming, whatever there is room for.
    if (room_in_piece(cloud_, choice_.kept, count, pieces_) < count && cloud_.size() > 0)
      pieces_.take(cloud_);
    shift_ = static_cast<std::int64_t>(cloud_.size()) - static_cast<std::int64_t>(count_);
    count_ += count;
    append_rows(cloud_, choice_.kept, static_cast<std::size_t>(count));
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
    about_.path = file_.name();
    about_.format = !laz_ ? "LAS" : records_.copc_info ? "COPC" : "LAZ";
    about_.version = fmt::format("1.{}", header_.version_minor);
    about_.point_format = header_.point_format;
    about_.point_count = header_.point_count;
    if (!header_.bounds.empty()) about_.stated_bounds = header_.bounds;
  }

  const CloudFile& file() const override { return about_; }
  AttributeSet attributes() const override { return columns_.attributes(); }
  FileFacts facts() const override;
  std::optional<Lattice> lattice() const override { return header_.lattice; }
  std::optional<std::uint64_t> point_count() const override { return header_.point_count; }
  CoordinateSurvey survey(const Progress&) override;
  void read_in_pieces(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                      const Progress& progress) override;
  std::vector<LostPoints> lost() const override;
  void rest() override { file_.rest(); }

 private:
  void read_plain(const LasColumns::Choice& choice, PointCloud& cloud, const CloudPieces& pieces,
                  const Progress& progress);

  InputFile file_;
  Damage damage_;
  std::vector<std::string> warnings_;
  LasHeader header_;
  LasRecords records_;
  std::optional<LazLayout> laz_;
  LasColumns columns_;
  CloudFile about_;
  std::vector<LostPoints> lost_;  ///< of compressed points
};

FileFacts LasReader::facts() const {
  return {.crs = records_.crs,
          .gps_time_is_standard = (header_.global_encoding & k_las_gps_time_is_standard) != 0,
          .project_id = header_.project_id,
          .file_source_id = header_.file_source_id,
          .box = widened_header_box(header_.bounds, header_.lattice)};
}

std::vector<LostPoints> LasReader::lost() const {
  if (header_.lost_count == 0) return lost_;
  return {{.count = header_.lost_count,
           .place = fmt::format("byte {}", file_.size()),
           .problem = "the file ends before its last point"}};
}

CoordinateSurvey LasReader::survey(const Progress&) {
  // The lattice is in the header: there is nothing to find out.
  return {};
}

void LasReader::read_in_pieces(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                               const Progress& progress) {
  const std::optional<glm::i64vec3> shift = steps_between(header_.lattice, cloud.lattice);
  if (!shift && header_.point_count > 0) {
    throw Error({.file = file_.name(), .problem = "does not share the lattice of the files before it"});
  }
  cloud.warnings.insert(cloud.warnings.end(), warnings_.begin(), warnings_.end());
  cloud.records.insert(cloud.records.end(), records_.others.begin(), records_.others.end());
  if (header_.point_count == 0) return;
  const LasColumns::Choice choice = columns_.choose(wanted, *shift, cloud);
  if (!laz_) {
    read_plain(choice, cloud, pieces, progress);
    return;
  }
  CloudRows rows(columns_, choice, header_.point_size, cloud, pieces);
  LazPoints points(file_, header_, *laz_, damage_);
  cloud.warnings.insert(cloud.warnings.end(), points.warnings().begin(), points.warnings().end());
  lost_ = points.read(layers_of(choice.kept), rows, progress);
  about_.point_count = rows.count();
}

void LasReader::read_plain(const LasColumns::Choice& choice, PointCloud& cloud, const CloudPieces& pieces,
                           const Progress& progress) {
  const std::size_t point_size = header_.point_size;
  const std::size_t step = std::max<std::size_t>(k_block_bytes / point_size, 1);
  std::uint64_t place = header_.points_place;
  while (place < header_.points_end()) {
    const std::uint64_t left = (header_.points_end() - place) / point_size;
    const std::size_t count = room_in_piece(cloud, choice.kept, std::min<std::uint64_t>(step, left), pieces);
    const RecordBlock block{file_.view(place, count * point_size).data(), point_size, count, cloud.size()};
    append_rows(cloud, choice.kept, count);
    columns_.take(block, choice, cloud);
    place += count * point_size;
    report(progress, place, file_.size());
  }
}

}  // namespace

std::unique_ptr<CloudReader> open_las(InputFile file, Damage damage) {
  return std::make_unique<LasReader>(std::move(file), damage);
}

}  // namespace alidade
