// SPDX-License-Identifier: MIT
#include "tools/cloud/crop_options.h"

#include <fmt/format.h>

#include "base/error.h"
#include "cloud/select_points.h"
#include "geo/vector_file.h"
#include "tools/load_module.h"
#include "tools/options.h"
#include "tools/split_list.h"

namespace alidade {
namespace {

/// Whether a text is meant as a box. A file whose name holds commas comes first.
bool is_box(const std::string& text) {
  std::error_code error;
  return text.find(',') != std::string::npos && !std::filesystem::exists(text, error);
}

Bounds parse_box(const std::string& text) {
  std::vector<double> numbers;
  for (const std::string& word : split_list(text)) numbers.push_back(parse_number(word));
  if (numbers.size() != 4 && numbers.size() != 6) {
    throw CLI::ValidationError("expected x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1 or a file of polygons, found '" +
                               text + "'");
  }
  const std::size_t axes = numbers.size() / 2;
  Bounds box{glm::dvec3(std::numeric_limits<double>::lowest()),
             glm::dvec3(std::numeric_limits<double>::max())};
  for (std::size_t axis = 0; axis < axes; ++axis) {
    const auto place = static_cast<int>(axis);
    box.min[place] = numbers[axis];
    box.max[place] = numbers[axes + axis];
    if (box.min[place] > box.max[place]) {
      throw CLI::ValidationError(fmt::format("expected the lower {0} first, found {0} from {1} to {2}",
                                             "xyz"[axis], box.min[place], box.max[place]));
    }
  }
  return box;
}

/// Where points were, also those of files that were left unread; empty if there were none.
std::string whereabouts(const PointCloud& cloud) {
  Bounds box = cloud.bounds();
  std::uint64_t skipped = 0;
  for (const CloudFile& file : cloud.files) {
    skipped += file.skipped_count;
    if (file.skipped_count > 0 && file.stated_bounds) box.grow(*file.stated_bounds);
  }
  if (cloud.size() + skipped == 0) return "";
  return fmt::format("points from {}, {}, {} to {}, {}, {}", box.min.x, box.min.y, box.min.z, box.max.x,
                     box.max.y, box.max.z);
}

std::vector<PlanePolygon> read_polygons(const CropOptions& options, const Crs& crs) {
  using Reader = void (*)(const std::filesystem::path& path, const ObserverReference& reference,
                          std::vector<PlanePolygon>& polygons);
  std::vector<PlanePolygon> polygons;
  load_module_function<Reader>("alidade_read_polygons")(
      options.polygons,
      {.given = options.reference, .cloud = crs, .option = "--crop-crs", .whose = "polygons"}, polygons);
  return polygons;
}

}  // namespace

void add_crop_options(CLI::App& command, CropOptions& options) {
  add_value(
      command, "--crop", "BOX|FILE",
      "keep what lies in x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1, coordinates of the cloud in its unit, mostly "
      "metres, or in the polygons of a GeoJSON, GeoPackage or Shapefile; what lies on the border stays",
      [&options](const std::string& text) {
        if (text.empty()) throw CLI::ValidationError("expected a box or a file, found nothing");
        options.text = text;
        options.box = is_box(text) ? std::optional(parse_box(text)) : std::nullopt;
        options.polygons = options.box ? "" : text;
      });
  add_value(command, "--crop-crs", "SYSTEM",
            "reference system of the polygons, as EPSG:4326, above what their file says; 'cloud' for the "
            "cloud's own",
            [&options](const std::string& text) { options.reference = text; });
}

void check_crop(const CropOptions& options) {
  if (options.polygons.empty()) {
    if (!options.reference.empty())
      throw Error({.problem = "--crop-crs is for polygons", .expected = "--crop FILE"});
    return;
  }
  std::error_code error;
  if (!std::filesystem::is_regular_file(options.polygons, error)) {
    throw Error({.file = options.polygons.string(),
                 .problem = "is no file",
                 .expected = "x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1 or a file of polygons"});
  }
}

void crop(PointCloud& cloud, const CropOptions& options, const Progress& progress) {
  if (!options.given()) return;
  const std::string before = whereabouts(cloud);
  if (options.box) {
    crop(cloud, *options.box, progress);
  } else {
    crop(cloud, read_polygons(options, cloud.crs), progress);
  }
  if (cloud.size() == 0 && !before.empty()) {
    throw Error({.file = options.polygons.string(),
                 .problem = options.box ? fmt::format("no point lies in --crop {}", options.text)
                                        : "no point lies in the polygons",
                 .expected = "a part of the cloud",
                 .found = before});
  }
}

}  // namespace alidade
