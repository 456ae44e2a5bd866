// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cloud/e57/e57_file.h"
#include "cloud/point_cloud.h"
#include "database/cloud_statistics.h"
#include "jobs/cloud_request.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"

namespace alidade::jobs {

/// What cloud files are, taken together as one cloud. `memory`: bytes for points, 4 GiB by default; those of
/// a larger cloud are kept in temporary_folder(). `overwrite`: existing images.
struct InfoRequest : CloudRequest {
  bool stats = false;                  ///< InfoResult::statistics, which needs all attributes
  bool verify = false;                 ///< the files are index files: IndexFile::verify()
  std::filesystem::path image_folder;  ///< extract_images() of E57 files; empty: none
};

/// Declares all fields.
void add_info_fields(const Fields& fields, InfoRequest& request);

/// A checked request. Nothing can be checked before files are read.
using InfoPlan = Plan<InfoRequest>;
InfoPlan plan(const InfoRequest& request);

/// An index file beside the facts of its points.
struct IndexFacts {
  std::string name, organisation;
  std::uint64_t bytes;
  double bytes_per_point, octree_bytes_per_point;  ///< of all, of the octree alone; 0 without points
  std::uint32_t levels, nodes;
  bool is_in_stored_order;  ///< points are numbered as the octree stores them
  int spacing_neighbours;   ///< 0: no spacings
  bool has_surfaces;
};

struct InfoResult {
  PointCloud facts{};  ///< lattice, reference system, files, records and warnings; no points
  std::uint64_t point_count = 0;
  AttributeSet attributes{};                ///< of any file
  Bounds bounds{};                          ///< of the points themselves
  std::string plane_unit{}, height_unit{};  ///< "m", "us-ft", "deg", or empty if it is unknown
  bool states_height_unit = false;          ///< else that of heights is assumed
  glm::dvec3 rounding_error{0.0};           ///< largest error of a coordinate per axis; 0 for integers of LAS
  /// For each file of `facts` that states a box, the box of its points; empty for others.
  std::vector<Bounds> file_bounds{};
  /// For each COPC file of `facts`, its octree in words, or why it is unusable; empty for others.
  std::vector<std::string> octrees{};
  std::vector<IndexFacts> indexes{};  ///< of the files that are index files
  bool verified = false;              ///< the index files are intact
  std::vector<E57File> e57_files{};
  std::optional<database::CloudStatistics> statistics{};
};

/// Verifies, extracts images, then reads the points; of a single index file without `stats` only the header.
/// Warns of nothing: InfoResult::facts has the warnings. Errors: those of reading; a file to verify is no
/// index file, or is damaged; those of extract_images(); no room for temporary files. Cancelled.
InfoResult run(const InfoPlan& plan, Listener& listener);

/// The object that `alidade info --json` prints; tools/manuals/info.txt lists its keys.
nlohmann::ordered_json info_json(const InfoResult& info);

}  // namespace alidade::jobs
