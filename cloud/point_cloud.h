// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/bounds.h"
#include "cloud/attributes.h"
#include "cloud/crs.h"
#include "cloud/lattice.h"

namespace alidade {

/// A LAS variable length record that Alidade does not interpret and hands on unchanged (CRS and extra-bytes
/// records are not among them: they live in Crs and ExtraDimension).
struct VariableLengthRecord {
  std::string user_id;  ///< at most 16 bytes
  std::uint16_t record_id = 0;
  std::string description;  ///< at most 32 bytes
  std::vector<std::uint8_t> data;
  bool extended = false;  ///< stood after the points (EVLR)

  bool operator==(const VariableLengthRecord&) const = default;
};

/// What was learnt about one input file. Of an index file these are the files it was made of.
struct CloudFile {
  std::filesystem::path path;
  std::string format;                   ///< "LAS", "PLY", "PCD", "E57", "XYZ", "CSV", "PTS", "PTX", ...
  std::string version;                  ///< "1.2", "ascii 1.0", ... ; empty if the format has none
  std::optional<int> point_format;      ///< LAS point data record format
  std::uint64_t point_count = 0;        ///< points taken into the cloud
  std::uint64_t dropped_count = 0;      ///< points left out because they have no finite position
  std::uint64_t skipped_count = 0;      ///< points left unread, all of the file (ReadOptions::region)
  std::optional<Bounds> stated_bounds;  ///< box of its points by its header (LAS), which may be wrong
  std::uint64_t lost_count = 0;  ///< points that a damaged file does not give any more, as far as known
};

/// Where a scanner stood, by the pose of one of its scans.
struct ScannerPosition {
  std::string scan;          ///< name of the scan as the file gives it, maybe empty
  glm::dvec3 position{0.0};  ///< world coordinates

  bool operator==(const ScannerPosition&) const = default;
};

/// Points and their attributes, column by column. Point id = row; files in the order given.
/// Every attribute column is either empty (the cloud does not have it) or as long as `positions` was when
/// read.
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
  std::vector<ScannerPosition> scanner_positions;  ///< of scans with a pose (E57), in the files' order

  std::vector<CloudFile> files;
  std::vector<std::string> warnings;  ///< oddities that were read over, one sentence each, naming the file

  std::size_t size() const { return positions.size(); }

  /// World position of the point with this id.
  glm::dvec3 world(std::size_t id) const { return to_world(lattice, positions[id]); }

  /// The attributes that are present.
  AttributeSet attributes() const;

  /// Smallest box around all points, from the points themselves. Cost: one pass.
  Bounds bounds() const;

  /// Takes rows out of the attribute and position columns: `resize(n)` on every column that is present.
  void resize(std::size_t count);
};

/// Names as `alidade info` prints them, in the order of the bits: "color", "near_infrared", ...
std::vector<std::string> attribute_names(AttributeSet attributes);

}  // namespace alidade
