// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "octree/index_file/index_file.h"
#include "octree/index_file/index_header.h"
#include "octree/index_file/save_index.h"
#include "octree/query.h"
#include "octree/spacing.h"
#include "octree/tree_walk.h"
#include "surface/point_surface.h"
#include "surface/surface_cloud.h"
#include "tests/octree/index_file/index_test_support.h"
#include "tests/support/point_families.h"
#include "tests/support/seal_index.h"

// A sound index file to damage, and what to do with what comes of it.

namespace alidade::test {

using Bytes = std::vector<std::byte>;

inline PointCloud cloud_with_everything() {
  Random random("index damage");
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 1500; ++i) positions.push_back(glm::dvec3(20, 20, 2) * random.in_cube());
  // Far strays have exact positions beside their coordinates.
  for (int i = 0; i < 8; ++i) positions.push_back(2e6 * random.in_cube());
  PointCloud cloud = make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0)});
  fill_everything(cloud, random);
  return cloud;
}

/// The bytes of a sound index file.
inline const Bytes& sound_file() {
  static const Bytes bytes = [] {
    const auto path = test_folder() / "sound.alidade";
    const PointCloud cloud = cloud_with_everything();
    save_index(path, with_surfaces(with_spacings(build(cloud), 3)), cloud);
    return read_bytes(path);
  }();
  return bytes;
}

inline SectionRow section(const Bytes& file, IndexSection kind) {
  for (const SectionRow& row : section_rows(file))
    if (row.kind == static_cast<std::uint32_t>(kind)) return row;
  ADD_FAILURE() << "missing section" << name(kind);
  return {};
}

/// Byte of a node's field in the file.
inline std::size_t in_node(const Bytes& file, std::size_t node, std::size_t field) {
  return section(file, IndexSection::nodes).offset + node * sizeof(Node) + field;
}
inline constexpr std::size_t k_kind = offsetof(Node, kind), k_first_child = offsetof(Node, first_child),
                             k_first_point = offsetof(Node, first_point);

/// Uses a file as programs do: queries it, and looks up attributes by the ids of the answers.
inline void use(const IndexFile& index) {
  const Octree octree = index.octree();
  const AttributeColumns& columns = index.columns();
  Random random("use");
  std::uint64_t sum = 0;
  const auto look_up = [&](const std::optional<Hit>& hit) {
    if (!hit) return;
    ASSERT_LT(hit->point_id, octree.size());
    if (!columns.colors.empty()) sum += columns.colors[hit->point_id].x;
    if (!columns.normals.empty()) sum += columns.normals[hit->point_id].x > 0;
  };
  const PointLayers& layers = octree.layers();
  const bool has_spacings = layers.spacings != nullptr;
  const SurfaceCloud spheres = has_spacings ? SurfaceCloud::of_spheres(octree) : SurfaceCloud();
  std::vector<Ray> rays;
  for (int i = 0; i < 6; ++i) rays.push_back(make_ray(30.0 * random.in_cube(), random.direction()));
  for (const Ray& ray : rays) {
    for (const Measure measure : {Measure::t, Measure::entry})
      look_up(closest(octree, ray, {.radius = 0.3, .measure = measure}));
    if (has_spacings) {
      look_up(closest(spheres, ray, {.radius = 0.3, .spacing_factor = 0.5}));
      look_up(closest(spheres, ray, {.radius = 3.0, .spacing_factor = 2.0}));
      sum += occluded(spheres, ray, {.radius = 3.0, .spacing_factor = 2.0});
    }
    for (const Hit& hit : find(octree, ray, {.radius = 5.0, .measure = Measure::distance, .k = 4}))
      look_up(hit);
    sum += occluded(octree, ray, {.radius = 0.05});
    const bool is_layered = octree.view().organisation == Organisation::layered;
    sum += count(octree, ray, {.radius = 2.0, .max_level = is_layered ? 1 : k_all_levels});
  }
  std::vector<std::optional<Hit>> hits(rays.size());
  closest(octree, rays, {.radius = 1.0}, hits);
  for (const std::optional<Hit>& hit : hits) look_up(hit);
  if (has_spacings) {
    std::vector<std::optional<SurfaceHit>> met(rays.size());
    closest(spheres, rays, {.radius = 1.0, .spacing_factor = 1.0}, met);
    for (const std::optional<SurfaceHit>& hit : met) look_up(hit);
  }
  if (layers.surfaces != nullptr) {
    for (std::uint64_t id = 0; id < octree.size(); ++id) {
      const glm::dvec3 normal = surface_of(layers, id).normal;
      ASSERT_NEAR(glm::length(normal), 1.0, 1e-9);
      ASSERT_GT(edge_of(layers, id, normal).distance, 0.0);
    }
  }
  Bounds box, everywhere;
  box.grow(glm::dvec3(-5.0));
  box.grow(glm::dvec3(5.0));
  everywhere.grow(glm::dvec3(-1e9));
  everywhere.grow(glm::dvec3(1e9));
  sum += count(octree, box, {}) + count(octree, everywhere, {});
  for (const PointHit& hit : find(octree, box, {})) ASSERT_LT(hit.point_id, octree.size());
  for (const PointHit& hit : find(octree, glm::dvec3(1.0), {.k = 8})) ASSERT_LT(hit.point_id, octree.size());
  sum += static_cast<std::uint64_t>(positions_in_order(octree.view()).size());
  sum += index.records().size();
  EXPECT_GE(sum, 0u);
}

/// Whether a file is rejected; if not, everything that can be done with it is done.
inline bool is_rejected(const Bytes& bytes) {
  try {
    const IndexFile index = index_in_memory(bytes);
    use(index);
    CloudInputs files;
    files.inputs.push_back(cloud_in_memory(bytes, "memory", index_and_file_formats()));
    read_cloud(files);
    return false;
  } catch (const Error& error) {
    EXPECT_EQ(error.parts().file, "memory");
    return true;
  }
}

inline bool is_rejected_when_opened(const Bytes& bytes) {
  try {
    index_in_memory(bytes);
    return false;
  } catch (const Error&) {
    return true;
  }
}

inline bool is_rejected_when_verified(const Bytes& bytes) {
  try {
    index_in_memory(bytes).verify();
    return false;
  } catch (const Error&) {
    return true;
  }
}

}  // namespace alidade::test
