// SPDX-License-Identifier: MIT
// Any bytes as an index file, as they are and with checksums made right: an Error, or answers that stay
// inside.
#include <cstdint>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <optional>
#include <vector>

#include "cloud/cloud_reader.h"
#include "cloud/read_cloud.h"
#include "octree/index_file/index_file.h"
#include "octree/index_file/index_header.h"
#include "octree/query.h"
#include "surface/point_surface.h"
#include "surface/surface_cloud.h"
#include "tests/support/seal_index.h"

namespace alidade {
namespace {

void check_id(const Octree& octree, std::uint64_t point_id) {
  if (point_id >= octree.size()) std::abort();
}

void ask(const IndexFile& index) {
  const Octree octree = index.octree();
  const AttributeColumns& columns = index.columns();
  const Bounds& bounds = octree.bounds();
  std::vector<Ray> rays;
  for (const glm::dvec3& direction :
       {glm::dvec3(0, 0, -1), glm::dvec3(1, 0.1, 0), glm::dvec3(-0.3, 1, 0.2), glm::dvec3(0.5, 0.5, 0.7)})
    rays.push_back(make_ray(octree.size() > 0 ? bounds.center() : glm::dvec3(0), direction));
  std::optional<SurfaceCloud> spheres;
  if (octree.layers().spacings) spheres = SurfaceCloud::of_spheres(octree);
  const SurfaceQuery own_radii{.radius = 2.0, .spacing_factor = 0.5};
  for (const Ray& ray : rays) {
    for (const Measure measure : {Measure::t, Measure::entry}) {
      const auto hit = closest(octree, ray, {.radius = 0.5, .measure = measure});
      if (!hit) continue;
      check_id(octree, hit->point_id);
      if (!columns.colors.empty() && columns.colors[hit->point_id].x == 1) check_id(octree, 0);
    }
    occluded(octree, ray, {.radius = 0.1});
    if (spheres) {
      if (const auto hit = closest(*spheres, ray, own_radii)) check_id(octree, hit->point_id);
      occluded(*spheres, ray, own_radii);
    }
    for (const Hit& hit : find(octree, ray, {.measure = Measure::distance, .k = 3}))
      check_id(octree, hit.point_id);
  }
  std::vector<std::optional<Hit>> hits(rays.size());
  closest(octree, rays, {.radius = 1.0}, hits);
  std::vector<std::optional<SurfaceHit>> met(rays.size());
  if (spheres) closest(*spheres, rays, own_radii, met);
  count(octree, bounds, {});
  if (octree.layers().surfaces) {
    for (std::uint64_t id = 0; id < octree.size(); ++id)
      if (!(glm::length(surface_of(octree.layers(), id).normal) > 0.9)) std::abort();
    const SurfaceQuery discs{.radius = 2.0, .spacing_factor = 0.5, .discs = DiscQuery{}};
    closest(SurfaceCloud::of_discs(octree), rays, discs, met);
  }
  if (octree.size() > 0) {
    for (const PointHit& hit : find(octree, bounds.center(), {.k = 5})) check_id(octree, hit.point_id);
  }
}

void use(std::span<const std::byte> bytes) {
  // Each function gets the file even if another one rejects it.
  try {
    const IndexFile index(InputFile(bytes, "input"));
    ask(index);
    index.records();
    index.verify();
  } catch (const Error&) {
  }
  try {
    CloudInputs files;
    files.inputs.push_back(cloud_in_memory(bytes, "input", index_and_file_formats()));
    const PointCloud cloud = read_cloud(files);
    // A point takes six bytes at least.
    if (is_index_file(bytes) && cloud.size() * 6 > bytes.size()) std::abort();
  } catch (const Error&) {
  }
}

}  // namespace
}  // namespace alidade

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto input = std::as_bytes(std::span(data, size));
  std::vector<std::byte> bytes(input.begin(), input.end());
  // All other readers have targets of their own.
  if (!alidade::is_index_file(bytes)) return 0;
  alidade::use(bytes);
  alidade::test::seal(bytes);
  alidade::use(bytes);
  return 0;
}
