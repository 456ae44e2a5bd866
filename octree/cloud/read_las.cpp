// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "octree/cloud/append_rows.h"
#include "octree/cloud/byte_order.h"
#include "octree/cloud/cloud_reader.h"
#include "octree/cloud/fit_lattice.h"
#include "octree/cloud/las_header.h"
#include "octree/cloud/las_records.h"
#include "octree/error.h"

namespace alidade {
namespace {

constexpr std::size_t k_block_bytes = 1 << 20;

/// Points of one block of the file, and the rows of the cloud they go to.
struct Block {
  const std::byte* bytes;
  std::size_t point_size;
  std::size_t count;
  std::size_t first_row;
};

/// column[row] = value(point) for all points of a block, where `point` is the address of a record's
/// `place`-th byte.
template <class Column, class Value>
void take(const Block& block, int place, Column& column, Value value) {
  const std::byte* at = block.bytes + place;
  for (std::size_t i = 0; i < block.count; ++i, at += block.point_size)
    column[block.first_row + i] = value(at);
}

template <class T>
constexpr auto k_plain = [](const std::byte* at) { return load<T>(at); };

ReturnNumbers legacy_returns(const std::byte* at) {
  const unsigned bits = load<std::uint8_t>(at);
  return {.number = static_cast<std::uint8_t>(bits & 7), .count = static_cast<std::uint8_t>(bits >> 3 & 7)};
}

ReturnNumbers returns(const std::byte* at) {
  const unsigned bits = load<std::uint8_t>(at);
  return {.number = static_cast<std::uint8_t>(bits & 15), .count = static_cast<std::uint8_t>(bits >> 4)};
}

/// Scan direction and edge of flight line from the byte of the returns; synthetic, key point and withheld
/// from the upper bits of the classification behind it.
PointFlags legacy_flags(const std::byte* at) {
  return static_cast<PointFlags>((load<std::uint8_t>(at) & 0xc0) | load<std::uint8_t>(at + 1) >> 5);
}

std::uint8_t legacy_classification(const std::byte* at) {
  return load<std::uint8_t>(at) & 31;
}

float legacy_scan_angle(const std::byte* at) {
  return load<std::int8_t>(at);
}

float scan_angle(const std::byte* at) {
  return static_cast<float>(load<std::int16_t>(at) * k_las_scan_angle_step);
}

/// Index of the first of three dimensions that hold a normal as LasWriter writes it; empty if there are none.
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

class LasReader final : public CloudReader {
 public:
  explicit LasReader(InputFile file)
      : file_(std::move(file)),
        header_(read_las_header(file_, warnings_)),
        records_(read_las_records(file_, header_, warnings_)) {
    about_.path = file_.name();
    about_.format = "LAS";
    about_.version = fmt::format("1.{}", header_.version_minor);
    about_.point_format = header_.point_format;
    about_.point_count = header_.point_count;
    place_extra_dimensions();
  }

  const CloudFile& file() const override { return about_; }
  AttributeSet attributes() const override;
  std::optional<Lattice> lattice() const override { return header_.lattice; }
  std::optional<std::uint64_t> point_count() const override { return header_.point_count; }
  CoordinateSurvey survey(const Progress&) override;
  void read(PointCloud& cloud, AttributeSet wanted, const Progress& progress) override;
  void rest() override { file_.rest(); }

 private:
  struct PlacedDimension {
    ExtraDimension description;
    int place;  ///< byte within a point
  };

  void place_extra_dimensions();
  void add_file_facts(PointCloud& cloud) const;
  void take_positions(const Block& block, const glm::i64vec3& shift, PointCloud& cloud) const;
  void take_attributes(const Block& block, AttributeSet kept, PointCloud& cloud) const;

  InputFile file_;
  std::vector<std::string> warnings_;
  LasHeader header_;
  LasRecords records_;
  CloudFile about_;
  std::vector<PlacedDimension> extra_dimensions_;
  std::optional<int> normal_place_;
};

void LasReader::place_extra_dimensions() {
  const std::optional<std::size_t> normal = find_normal(records_.extra_dimensions);
  int place = header_.layout().size;
  for (std::size_t i = 0; i < records_.extra_dimensions.size(); ++i) {
    const ExtraDimension& dimension = records_.extra_dimensions[i];
    if (normal && i == *normal) normal_place_ = place;
    const bool part_of_normal = normal && i >= *normal && i < *normal + 3;
    if (!part_of_normal) extra_dimensions_.push_back({dimension, place});
    place += dimension.byte_count;
  }
}

AttributeSet LasReader::attributes() const {
  AttributeSet set = Attribute::intensity | Attribute::classification | Attribute::returns |
                     Attribute::flags | Attribute::scan_angle | Attribute::user_data |
                     Attribute::point_source_id;
  if (header_.layout().gps_time >= 0) set = set | Attribute::gps_time;
  if (header_.layout().color >= 0) set = set | Attribute::color;
  if (header_.layout().near_infrared >= 0) set = set | Attribute::near_infrared;
  if (normal_place_) set = set | Attribute::normal;
  if (!extra_dimensions_.empty()) set = set | Attribute::extra_dimensions;
  return set;
}

CoordinateSurvey LasReader::survey(const Progress&) {
  // The lattice is in the header: there is nothing to find out.
  return {};
}

void LasReader::add_file_facts(PointCloud& cloud) const {
  cloud.warnings.insert(cloud.warnings.end(), warnings_.begin(), warnings_.end());
  const bool gps_time_is_standard = (header_.global_encoding & k_las_gps_time_is_standard) != 0;
  if (cloud.files.empty()) {
    cloud.gps_time_is_standard = gps_time_is_standard;
    cloud.project_id = header_.project_id;
    cloud.file_source_id = header_.file_source_id;
  } else if (!cloud.gps_times.empty() && header_.layout().gps_time >= 0 &&
             cloud.gps_time_is_standard != gps_time_is_standard) {
    cloud.warnings.push_back(fmt::format(
        "{}: counts GPS time another way (week or standard) than the first file; the times do not compare",
        file_.name()));
  }
  if (cloud.crs.empty()) {
    cloud.crs = records_.crs;
  } else if (!records_.crs.empty() && records_.crs != cloud.crs) {
    cloud.warnings.push_back(
        fmt::format("{}: states another coordinate reference system than the files before it; theirs is kept",
                    file_.name()));
  }
  cloud.records.insert(cloud.records.end(), records_.others.begin(), records_.others.end());
}

void LasReader::take_positions(const Block& block, const glm::i64vec3& shift, PointCloud& cloud) const {
  if (shift == glm::i64vec3(0)) {
    take(block, 0, cloud.positions, k_plain<LatticePosition>);
    return;
  }
  for (std::size_t i = 0; i < block.count; ++i) {
    const glm::i64vec3 steps =
        glm::i64vec3(load<LatticePosition>(block.bytes + i * block.point_size)) + shift;
    const LatticePosition position(steps);
    if (glm::i64vec3(position) != steps) {
      throw Error({.file = file_.name(),
                   .problem = "lies too far from the first file to share its lattice of 32-bit steps",
                   .found = fmt::format("step {}, {}, {}", steps.x, steps.y, steps.z)});
    }
    cloud.positions[block.first_row + i] = position;
  }
}

void LasReader::take_attributes(const Block& block, AttributeSet kept, PointCloud& cloud) const {
  const LasPointLayout& layout = header_.layout();
  const bool legacy = layout.legacy;
  if (kept.contains(Attribute::intensity)) take(block, 12, cloud.intensities, k_plain<std::uint16_t>);
  if (kept.contains(Attribute::returns)) {
    if (legacy) {
      take(block, 14, cloud.returns, legacy_returns);
    } else {
      take(block, 14, cloud.returns, returns);
    }
  }
  if (kept.contains(Attribute::flags)) {
    if (legacy) {
      take(block, 14, cloud.flags, legacy_flags);
    } else {
      take(block, 15, cloud.flags, k_plain<PointFlags>);
    }
  }
  if (kept.contains(Attribute::classification)) {
    if (legacy) {
      take(block, 15, cloud.classifications, legacy_classification);
    } else {
      take(block, 16, cloud.classifications, k_plain<std::uint8_t>);
    }
  }
  if (kept.contains(Attribute::scan_angle)) {
    if (legacy) {
      take(block, 16, cloud.scan_angles, legacy_scan_angle);
    } else {
      take(block, 18, cloud.scan_angles, scan_angle);
    }
  }
  if (kept.contains(Attribute::user_data)) take(block, 17, cloud.user_data, k_plain<std::uint8_t>);
  if (kept.contains(Attribute::point_source_id)) {
    take(block, legacy ? 18 : 20, cloud.point_source_ids, k_plain<std::uint16_t>);
  }
  if (kept.contains(Attribute::gps_time)) take(block, layout.gps_time, cloud.gps_times, k_plain<double>);
  if (kept.contains(Attribute::color)) take(block, layout.color, cloud.colors, k_plain<Color16>);
  if (kept.contains(Attribute::near_infrared)) {
    take(block, layout.near_infrared, cloud.near_infrared, k_plain<std::uint16_t>);
  }
  if (kept.contains(Attribute::normal)) take(block, *normal_place_, cloud.normals, k_plain<glm::vec3>);
}

void LasReader::read(PointCloud& cloud, AttributeSet wanted, const Progress& progress) {
  const std::optional<glm::i64vec3> shift = steps_between(header_.lattice, cloud.lattice);
  if (!shift && header_.point_count > 0) {
    throw Error({.file = file_.name(), .problem = "does not share the lattice of the files before it"});
  }
  add_file_facts(cloud);
  const AttributeSet kept = attributes() & wanted;
  std::vector<std::size_t> columns;
  if (kept.contains(Attribute::extra_dimensions) && header_.point_count > 0) {
    for (std::size_t i = 0; i < extra_dimensions_.size(); ++i) {
      const ExtraDimension& like = extra_dimensions_[i].description;
      const auto equal = std::count_if(
          extra_dimensions_.begin(), extra_dimensions_.begin() + static_cast<std::ptrdiff_t>(i),
          [&](const PlacedDimension& earlier) { return same_meaning(earlier.description, like); });
      columns.push_back(find_extra_dimension(cloud, like, static_cast<std::size_t>(equal)));
    }
  }
  const std::size_t point_size = header_.point_size;
  const std::size_t step = std::max<std::size_t>(k_block_bytes / point_size, 1);
  std::uint64_t place = header_.points_place;
  while (place < header_.points_end()) {
    const std::size_t count =
        static_cast<std::size_t>(std::min<std::uint64_t>(step, (header_.points_end() - place) / point_size));
    const Block block{file_.view(place, count * point_size).data(), point_size, count, cloud.size()};
    append_rows(cloud, kept, count);
    take_positions(block, *shift, cloud);
    take_attributes(block, kept, cloud);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      ExtraDimension& column = cloud.extra_dimensions[columns[i]];
      const std::size_t bytes = static_cast<std::size_t>(column.byte_count);
      for (std::size_t row = 0; row < count; ++row) {
        std::memcpy(column.values.data() + (block.first_row + row) * bytes,
                    block.bytes + row * point_size + extra_dimensions_[i].place, bytes);
      }
    }
    place += count * point_size;
    report(progress, place, file_.size());
  }
}

}  // namespace

std::unique_ptr<CloudReader> open_las(InputFile file) {
  return std::make_unique<LasReader>(std::move(file));
}

}  // namespace alidade
