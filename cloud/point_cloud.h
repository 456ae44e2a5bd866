// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/bounds.h"
#include "cloud/attributes.h"
#include "cloud/crs.h"
#include "cloud/lattice.h"

namespace alidade {

/// A LAS variable length record that is not interpreted and is written unchanged (CRS and extra-bytes records
/// are not among them: they become Crs and ExtraDimension).
struct VariableLengthRecord {
  std::string user_id;  ///< at most 16 bytes
  std::uint16_t record_id = 0;
  std::string description;  ///< at most 32 bytes
  std::vector<std::uint8_t> data;
  bool extended = false;  ///< behind the points in the file (EVLR)

  bool operator==(const VariableLengthRecord&) const = default;
};

/// Facts about one input file. An index file has those of the files it was built from.
struct CloudFile {
  std::filesystem::path path;
  std::string format;                   ///< "LAS", "PLY", "PCD", "E57", "XYZ", "CSV", "PTS", "PTX", ...
  std::string version;                  ///< "1.2", "ascii 1.0", ... ; empty if the format has none
  std::optional<int> point_format;      ///< LAS point data record format
  std::uint64_t point_count = 0;        ///< points taken into the cloud
  std::uint64_t dropped_count = 0;      ///< points left out because they have no finite position
  std::uint64_t skipped_count = 0;      ///< points not read: all of the file, or none (ReadOptions::region)
  std::optional<Bounds> stated_bounds;  ///< box of its points by its header (LAS), which may be wrong
  std::uint64_t lost_count = 0;         ///< points of a damaged file that cannot be read, as far as known
  std::uint64_t left_out_count = 0;     ///< points that were not selected (cloud/input_view.h)
  std::string software{};               ///< that wrote it, by its header (LAS); empty if unknown
  std::string system_identifier{};      ///< of the sensor or the processing, by its header (LAS)
  std::string created{};                ///< "2019-05-02", by its header (LAS)
  bool is_rounded = false;              ///< whether its lattice is not that of the cloud, nor a part of it
};

/// Orientation of a depth camera: unit vectors at right angles, world axes.
struct DepthCameraAxes {
  glm::dvec3 forward{0.0, 0.0, 1.0};
  glm::dvec3 down{0.0, 1.0, 0.0};  ///< in its image

  bool operator==(const DepthCameraAxes&) const = default;
};

/// The position of a scanner, by the pose of one of its scans.
struct ScannerPosition {
  std::string scan;          ///< name of the scan in the file; may be empty
  glm::dvec3 position{0.0};  ///< world coordinates
  /// Of a depth camera; empty for scanners that scan all around.
  std::optional<DepthCameraAxes> axes{};

  bool operator==(const ScannerPosition&) const = default;
};

/// Points and their attributes, column by column. Point id = row; files in the given order. Every attribute
/// column is either empty (the cloud does not have it) or as long as `positions` was when read.
struct PointCloud {
  Lattice lattice;
  std::vector<LatticePosition> positions;

  std::vector<Color16> colors;
  std::vector<std::uint16_t> near_infrared;
  std::vector<std::uint16_t> intensities;     ///< 0 .. 65535
  std::vector<std::uint8_t> classifications;  ///< ASPRS classes
  std::vector<ReturnNumbers> returns;
  std::vector<PointFlags> flags;
  std::vector<float> scan_angles;  ///< degrees
  std::vector<std::uint8_t> user_data;
  std::vector<std::uint16_t> point_source_ids;
  std::vector<double> gps_times;  ///< seconds, in the time system of `gps_time_is_standard`
  std::vector<glm::vec3> normals;
  std::vector<ExtraDimension> extra_dimensions;

  Crs crs;
  std::vector<VariableLengthRecord> records;
  bool gps_time_is_standard = false;          ///< LAS global encoding bit 0: adjusted standard GPS time
  std::array<std::uint8_t, 16> project_id{};  ///< LAS project GUID, first file's
  std::uint16_t file_source_id = 0;
  /// Of scans with a pose (E57, PTX, PCD), in the order of the files.
  std::vector<ScannerPosition> scanner_positions;

  std::vector<CloudFile> files;
  std::vector<std::string> warnings;  ///< on oddities of the files, one sentence each, naming the file

  std::size_t size() const { return positions.size(); }

  /// World position of the point with this id.
  glm::dvec3 world(std::size_t id) const { return to_world(lattice, positions[id]); }

  /// The attributes that are present.
  AttributeSet attributes() const;

  /// Smallest box around all points, from the points themselves: bounds_of().
  Bounds bounds() const;

  /// Calls `resize(count)` on the positions and every attribute column that is present.
  void resize(std::size_t count);
};

/// Names as `alidade info` prints them, in the order of the bits: "color", "near_infrared", ...
/// Attribute::returns has two: "return_number" and "number_of_returns".
std::vector<std::string> attribute_names(AttributeSet attributes);

/// A column of values that is not one of the standard attributes, in memory of any owner.
struct ExtraColumn {
  ExtraDimension description;            ///< its `values` are empty
  std::span<const std::uint8_t> values;  ///< byte_count bytes per point, little endian, in point order
};

/// A colour of 8 bits per channel. With a factor it represents the Color16 of its values times the factor.
using Color8 = glm::u8vec3;

/// Colours by point id, in memory of any owner: a span of Color16, or of Color8 if all are multiples of one
/// factor, as index files store colours of 8 bits.
class ColorColumn {
 public:
  ColorColumn() = default;
  // Implicit, as the other columns take spans and vectors.
  ColorColumn(std::span<const Color16> colors)  // NOLINT(google-explicit-constructor)
      : deep_(colors.data()), size_(colors.size()) {}
  ColorColumn(const std::vector<Color16>& colors)  // NOLINT(google-explicit-constructor)
      : ColorColumn(std::span(colors)) {}
  ColorColumn(std::span<const Color8> colors, std::uint16_t factor)
      : shallow_(colors.data()), factor_(factor), size_(colors.size()) {}

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  Color16 operator[](std::size_t id) const {
    return shallow_ == nullptr ? deep_[id] : Color16(shallow_[id]) * factor_;
  }
  ColorColumn subspan(std::size_t first, std::size_t count) const {
    return shallow_ == nullptr ? ColorColumn(deep().subspan(first, count))
                               : ColorColumn(shallow().subspan(first, count), factor_);
  }

  /// The colours as stored in memory; one of the two spans is empty.
  std::span<const Color16> deep() const { return {deep_, deep_ == nullptr ? 0 : size_}; }
  std::span<const Color8> shallow() const { return {shallow_, shallow_ == nullptr ? 0 : size_}; }

  /// The factor of Color8; 1 for Color16.
  std::uint16_t factor() const { return factor_; }

  class Iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using value_type = Color16;
    using difference_type = std::ptrdiff_t;
    using pointer = void;
    using reference = Color16;

    Iterator() = default;
    Iterator(const ColorColumn& column, std::size_t id) : column_(&column), id_(id) {}
    Color16 operator*() const { return (*column_)[id_]; }
    Iterator& operator++() {
      ++id_;
      return *this;
    }
    Iterator operator++(int) { return {*column_, id_++}; }
    bool operator==(const Iterator& other) const { return id_ == other.id_; }

   private:
    const ColorColumn* column_ = nullptr;
    std::size_t id_ = 0;
  };
  /// The column must outlive them.
  Iterator begin() const { return {*this, 0}; }
  Iterator end() const { return {*this, size_}; }

 private:
  const Color16* deep_ = nullptr;
  const Color8* shallow_ = nullptr;
  std::uint16_t factor_ = 1;
  std::size_t size_ = 0;
};

/// The attribute columns of a cloud, in memory of any owner: of a PointCloud, or of an index file that is
/// mapped into memory. Row = point id. A column is empty if the cloud does not have it. Names and meaning are
/// those of PointCloud.
struct AttributeColumns {
  ColorColumn colors;
  std::span<const std::uint16_t> near_infrared;
  std::span<const std::uint16_t> intensities;
  std::span<const std::uint8_t> classifications;
  std::span<const ReturnNumbers> returns;
  std::span<const PointFlags> flags;
  std::span<const float> scan_angles;
  std::span<const std::uint8_t> user_data;
  std::span<const std::uint16_t> point_source_ids;
  std::span<const double> gps_times;
  std::span<const glm::vec3> normals;
  std::vector<ExtraColumn> extra_dimensions;

  /// The attributes that are present.
  AttributeSet attributes() const;
};

/// The points of a cloud, in memory of any owner.
struct PointColumns {
  Lattice lattice;
  std::span<const LatticePosition> positions;
  AttributeColumns attributes;

  std::size_t size() const { return positions.size(); }
  /// World position of the point with this id.
  glm::dvec3 world(std::size_t id) const { return to_world(lattice, positions[id]); }
};

/// Smallest box around some points. Cost: one pass.
Bounds bounds_of(const Lattice& lattice, std::span<const LatticePosition> positions);

/// Calls visit(attribute, column of a, column of b) for every column but the extra dimensions; a and b are
/// each a PointCloud or AttributeColumns.
template <class CloudA, class CloudB, class Visit>
void for_each_column(CloudA& a, CloudB& b, const Visit& visit) {
  visit(Attribute::color, a.colors, b.colors);
  visit(Attribute::near_infrared, a.near_infrared, b.near_infrared);
  visit(Attribute::intensity, a.intensities, b.intensities);
  visit(Attribute::classification, a.classifications, b.classifications);
  visit(Attribute::returns, a.returns, b.returns);
  visit(Attribute::flags, a.flags, b.flags);
  visit(Attribute::scan_angle, a.scan_angles, b.scan_angles);
  visit(Attribute::user_data, a.user_data, b.user_data);
  visit(Attribute::point_source_id, a.point_source_ids, b.point_source_ids);
  visit(Attribute::gps_time, a.gps_times, b.gps_times);
  visit(Attribute::normal, a.normals, b.normals);
}

/// Calls visit(attribute, column) for every column of one cloud but the extra dimensions.
template <class Cloud, class Visit>
void for_each_column(Cloud& cloud, const Visit& visit) {
  for_each_column(cloud, cloud, [&](Attribute attribute, auto& column, auto&) { visit(attribute, column); });
}

/// The columns of a cloud, which must outlive them and keep its size.
AttributeColumns columns_of(const PointCloud& cloud);
/// The columns of a cloud and its positions, which must outlive them and keep their size.
PointColumns points_of(const PointCloud& cloud);

/// Whether the points of a file have the fields of LAS, packed or not.
inline bool is_las(const CloudFile& file) {
  return file.format == "LAS" || file.format == "LAZ" || file.format == "COPC";
}

}  // namespace alidade
