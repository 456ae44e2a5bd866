// SPDX-License-Identifier: MIT
#include "cloud/las/las_records.h"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <utility>

#include "base/bytes.h"
#include "cloud/cloud_reader.h"
#include "cloud/lattice.h"
#include "cloud/laz/laz_layout.h"
#include "cloud/laz/laz_points.h"
#include "cloud/rows.h"
#include "cloud/table_reader.h"

namespace alidade {
namespace {

/// column[row] = value(at) for all points of a block, where `at` points to byte `offset` of the record.
template <class Column, class Value>
void fill(const RecordBlock& block, int offset, Column& column, Value value) {
  const std::byte* at = block.bytes + offset;
  for (std::size_t i = 0; i < block.count; ++i, at += block.point_size)
    column[block.first_row + i] = value(at);
}

template <class T>
constexpr auto k_plain = [](const std::byte* at) { return load<T>(at); };

constexpr auto k_legacy_returns = [](const std::byte* at) -> ReturnNumbers {
  const unsigned bits = load<std::uint8_t>(at);
  return {.number = static_cast<std::uint8_t>(bits & 7), .count = static_cast<std::uint8_t>(bits >> 3 & 7)};
};

constexpr auto k_returns = [](const std::byte* at) -> ReturnNumbers {
  const unsigned bits = load<std::uint8_t>(at);
  return {.number = static_cast<std::uint8_t>(bits & 15), .count = static_cast<std::uint8_t>(bits >> 4)};
};

/// Scan direction and edge of flight line are bits of the returns' byte; synthetic, key point and withheld
/// the upper bits of the classification behind it.
constexpr auto k_legacy_flags = [](const std::byte* at) -> PointFlags {
  return static_cast<PointFlags>((load<std::uint8_t>(at) & 0xc0) | load<std::uint8_t>(at + 1) >> 5);
};

constexpr auto k_legacy_classification = [](const std::byte* at) -> std::uint8_t {
  return load<std::uint8_t>(at) & 31;
};

constexpr auto k_legacy_scan_angle = [](const std::byte* at) -> float { return load<std::int8_t>(at); };

constexpr auto k_scan_angle = [](const std::byte* at) -> float {
  return static_cast<float>(load<std::int16_t>(at) * k_las_scan_angle_step);
};

/// Index of the first of three dimensions that hold a normal as LasWriter writes it; empty if missing.
std::optional<std::size_t> find_normal(const std::vector<ExtraDimension>& dimensions) {
  const auto is = [](const ExtraDimension& dimension, const char* name) {
    return dimension.name == name && dimension.type == ScalarType::float32 && !dimension.has_scale &&
           !dimension.has_offset;
  };
  for (std::size_t i = 0; i + 2 < dimensions.size(); ++i) {
    if (is(dimensions[i], "NormalX") && is(dimensions[i + 1], "NormalY") && is(dimensions[i + 2], "NormalZ"))
      return i;
  }
  return std::nullopt;
}

/// Fills positions, in steps of the cloud's lattice.
void take_positions(const RecordBlock& block, const LatticeShift& shift, PointCloud& cloud) {
  if (shift.is_none()) {
    fill(block, 0, cloud.positions, k_plain<LatticePosition>);
  } else {
    fill(block, 0, cloud.positions, [&](const std::byte* at) { return shift(load<LatticePosition>(at)); });
  }
}

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
    about_.path = file_.name();
    about_.format = !laz_ ? "LAS" : records_.copc_info ? "COPC" : "LAZ";
    about_.version = fmt::format("1.{}", header_.version_minor);
    about_.point_format = header_.point_format;
    about_.point_count = header_.point_count;
    if (!header_.bounds.empty()) about_.stated_bounds = header_.bounds;
    about_.software = header_.generating_software;
    about_.system_identifier = header_.system_identifier;
    if (header_.creation_year > 0 && header_.creation_day > 0 && header_.creation_day <= 366) {
      using namespace std::chrono;
      const year_month_day day =
          sys_days(year(header_.creation_year) / January / 1) + days(header_.creation_day - 1);
      about_.created = fmt::format("{:04}-{:02}-{:02}", static_cast<int>(day.year()),
                                   static_cast<unsigned>(day.month()), static_cast<unsigned>(day.day()));
    }
  }

  const CloudFile& file() const override { return about_; }
  AttributeSet attributes() const override { return columns_.attributes(); }

  FileFacts facts() const override {
    return {.crs = records_.crs,
            .gps_time_is_standard = (header_.global_encoding & k_las_gps_time_is_standard) != 0,
            .project_id = header_.project_id,
            .file_source_id = header_.file_source_id,
            .box = widened_header_box(header_.bounds, header_.lattice)};
  }

  std::optional<Lattice> lattice() const override { return header_.lattice; }
  std::optional<std::uint64_t> point_count() const override { return header_.point_count; }

  void read_in_pieces(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                      const Progress& progress) override {
    cloud.warnings.insert(cloud.warnings.end(), warnings_.begin(), warnings_.end());
    cloud.records.insert(cloud.records.end(), records_.others.begin(), records_.others.end());
    if (header_.point_count == 0) return;
    const LasColumns::Choice choice = columns_.choose(wanted, cloud);
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

  std::vector<LostPoints> lost() const override {
    if (header_.lost_count == 0) return lost_;
    return {{.count = header_.lost_count,
             .location = fmt::format("byte {}", file_.size()),
             .problem = "truncated file: it ends before its last point"}};
  }

  void rest() override { file_.rest(); }

 private:
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
  CloudFile about_;
  std::vector<LostPoints> lost_;  ///< of compressed points
};

}  // namespace

LasColumns::LasColumns(std::string file_name, const LasHeader& header,
                       const std::vector<ExtraDimension>& extra_dimensions)
    : file_name_(std::move(file_name)), lattice_(header.lattice), layout_(header.layout()) {
  const std::optional<std::size_t> normal = find_normal(extra_dimensions);
  int offset = layout_.size;
  for (std::size_t i = 0; i < extra_dimensions.size(); ++i) {
    const ExtraDimension& dimension = extra_dimensions[i];
    if (normal && i == *normal) normal_offset_ = offset;
    const bool part_of_normal = normal && i >= *normal && i < *normal + 3;
    if (!part_of_normal) extra_dimensions_.push_back({dimension, offset});
    offset += dimension.byte_count;
  }
}

AttributeSet LasColumns::attributes() const {
  AttributeSet set = Attribute::intensity | Attribute::classification | Attribute::returns |
                     Attribute::flags | Attribute::scan_angle | Attribute::user_data |
                     Attribute::point_source_id;
  if (layout_.gps_time >= 0) set = set | Attribute::gps_time;
  if (layout_.color >= 0) set = set | Attribute::color;
  if (layout_.near_infrared >= 0) set = set | Attribute::near_infrared;
  if (normal_offset_) set = set | Attribute::normal;
  if (!extra_dimensions_.empty()) set = set | Attribute::extra_dimensions;
  return set;
}

LasColumns::Choice LasColumns::choose(AttributeSet wanted, PointCloud& cloud) const {
  Choice choice{attributes() & wanted, LatticeShift(lattice_, cloud.lattice, file_name_), {}};
  if (!choice.kept.contains(Attribute::extra_dimensions)) return choice;
  for (std::size_t i = 0; i < extra_dimensions_.size(); ++i) {
    const std::size_t occurrence = occurrence_of(extra_dimensions_, i, &PlacedDimension::description);
    choice.extra_columns.push_back(find_extra_dimension(cloud, extra_dimensions_[i].description, occurrence));
  }
  return choice;
}

void LasColumns::take(const RecordBlock& block, const Choice& choice, PointCloud& cloud) const {
  take_positions(block, choice.shift, cloud);
  take_attributes(block, choice.kept, cloud);
  for (std::size_t i = 0; i < choice.extra_columns.size(); ++i) {
    ExtraDimension& column = cloud.extra_dimensions[choice.extra_columns[i]];
    const std::size_t bytes = static_cast<std::size_t>(column.byte_count);
    for (std::size_t row = 0; row < block.count; ++row) {
      std::memcpy(column.values.data() + (block.first_row + row) * bytes,
                  block.bytes + row * block.point_size + extra_dimensions_[i].offset, bytes);
    }
  }
}

void LasColumns::take_attributes(const RecordBlock& block, AttributeSet kept, PointCloud& cloud) const {
  const auto keep = [&](Attribute attribute, int offset, auto& column, auto value) {
    if (kept.contains(attribute)) fill(block, offset, column, value);
  };
  keep(Attribute::intensity, 12, cloud.intensities, k_plain<std::uint16_t>);
  if (layout_.legacy) {
    keep(Attribute::returns, 14, cloud.returns, k_legacy_returns);
    keep(Attribute::flags, 14, cloud.flags, k_legacy_flags);
    keep(Attribute::classification, 15, cloud.classifications, k_legacy_classification);
    keep(Attribute::scan_angle, 16, cloud.scan_angles, k_legacy_scan_angle);
  } else {
    keep(Attribute::returns, 14, cloud.returns, k_returns);
    keep(Attribute::flags, 15, cloud.flags, k_plain<PointFlags>);
    keep(Attribute::classification, 16, cloud.classifications, k_plain<std::uint8_t>);
    keep(Attribute::scan_angle, 18, cloud.scan_angles, k_scan_angle);
  }
  keep(Attribute::user_data, 17, cloud.user_data, k_plain<std::uint8_t>);
  keep(Attribute::point_source_id, layout_.legacy ? 18 : 20, cloud.point_source_ids, k_plain<std::uint16_t>);
  keep(Attribute::gps_time, layout_.gps_time, cloud.gps_times, k_plain<double>);
  keep(Attribute::color, layout_.color, cloud.colors, k_plain<Color16>);
  keep(Attribute::near_infrared, layout_.near_infrared, cloud.near_infrared, k_plain<std::uint16_t>);
  keep(Attribute::normal, normal_offset_.value_or(0), cloud.normals, k_plain<glm::vec3>);
}

std::unique_ptr<CloudReader> open_las(InputFile file, Damage damage) {
  return std::make_unique<LasReader>(std::move(file), damage);
}

}  // namespace alidade
