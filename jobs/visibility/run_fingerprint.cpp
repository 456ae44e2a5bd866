// SPDX-License-Identifier: MIT
#include "jobs/visibility/run_fingerprint.h"

#include <fmt/format.h>
#include <array>

#include "base/checkpoint.h"

namespace alidade::jobs {
namespace {

/// Points and triangles are in the fingerprint, not the names of their files; lists, curve, preview and
/// footprints are outputs, and colours of photos follow from what is seen.
constexpr std::array<std::string_view, 10> k_silent_fields = {
    "cloud",          "lists",  "curve",    "preview", "footprints",
    "footprint-cell", "photos", "colorize", "mesh",    "terrain"};

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + name_in_checkpoint(word);
  return text.empty() ? "none" : text;
}

std::string sum_text(std::span<const std::uint64_t> sums) {
  return fmt::format("{:016x}", checksum(std::as_bytes(sums)));
}

template <class Value>
std::uint64_t sum_of(const std::vector<Value>& values) {
  return checksum(std::as_bytes(std::span(values)));
}

/// Checksum of the octree as it was loaded: points, and surfaces that an index file contains. Surfaces
/// measured by this run follow from the points.
std::string points_checksum(const IndexedCloud& cloud) {
  const TreeView& tree = cloud.octree.view();
  std::vector<std::uint64_t> sums;
  append_tree_checksums(tree, sums);
  const auto append = [&](const auto* values) {
    if (values != nullptr) sums.push_back(checksum(std::as_bytes(std::span(values, tree.point_count))));
  };
  const PointLayers& layers = cloud.octree.layers();
  append(layers.spacings);
  append(layers.surfaces);
  append(layers.sheet_edges);
  return sum_text(sums);
}

/// The reference system is part of the fingerprint since it defines units of length.
std::string crs_checksum(const Crs& crs) {
  if (crs.empty()) return "none";
  const std::uint64_t sums[] = {checksum(std::as_bytes(std::span(crs.wkt))), sum_of(crs.geotiff_keys),
                                sum_of(crs.geotiff_doubles),
                                checksum(std::as_bytes(std::span(crs.geotiff_ascii)))};
  return sum_text(sums);
}

}  // namespace

Fingerprint run_fingerprint(const CheckpointRequest& request, const VisibilityCloud& cloud) {
  Fingerprint fingerprint{{"command", request.fields->name()},
                          {"version of answers", std::to_string(visibility::k_answers_version)}};
  for (const auto& [name, words] : request.fields->given()) {
    if (is_silent(name, k_silent_fields)) continue;
    fingerprint.push_back({"--" + name, joined(words)});
  }
  const Bounds& box = cloud.cloud.octree.bounds();
  fingerprint.push_back({"number of points", std::to_string(cloud.cloud.octree.size())});
  fingerprint.push_back(
      {"bounds of the points", fmt::format("{:.17g} {:.17g} {:.17g} to {:.17g} {:.17g} {:.17g}", box.min.x,
                                           box.min.y, box.min.z, box.max.x, box.max.y, box.max.z)});
  fingerprint.push_back({"reference system", crs_checksum(cloud.cloud.cloud.crs)});
  fingerprint.push_back({"points", points_checksum(cloud.cloud)});
  const std::uint64_t classes = checksum(std::as_bytes(cloud.columns.classifications));
  fingerprint.push_back(
      {"classes", cloud.columns.classifications.empty() ? "none" : sum_text({&classes, 1})});
  if (cloud.mesh.tree != nullptr)
    fingerprint.push_back({"meshes", fmt::format("{:016x}", cloud.mesh.checksum)});
  if (cloud.terrain.surface != nullptr)
    fingerprint.push_back({"terrain", fmt::format("{:016x}", cloud.terrain.checksum)});
  return fingerprint;
}

Fingerprint run_fingerprint(const CheckpointRequest& request, const VisibilityCloud& cloud,
                            std::span<const visibility::Observer> observers) {
  Fingerprint fingerprint = run_fingerprint(request, cloud);
  std::vector<double> numbers;
  for (const visibility::Observer& one : observers) {
    numbers.insert(numbers.end(), {one.position.x, one.position.y, one.position.z, one.azimuth_min,
                                   one.azimuth_max, one.elevation_min, one.elevation_max, one.max_distance});
  }
  fingerprint.push_back({"number of observers", std::to_string(observers.size())});
  add_to_fingerprint("observers", numbers, fingerprint);
  return fingerprint;
}

void add_to_fingerprint(const geo::RasterGrid& grid, Fingerprint& fingerprint) {
  fingerprint.push_back(
      {"cells", fmt::format("{} x {} of {:.17g} from {:.17g} {:.17g}", grid.columns, grid.rows,
                            grid.cell_size, grid.north_west.x, grid.north_west.y)});
}

void add_to_fingerprint(const std::string& name, std::span<const double> numbers, Fingerprint& fingerprint) {
  fingerprint.push_back({name, fmt::format("{:016x}", checksum(std::as_bytes(numbers)))});
}

}  // namespace alidade::jobs
