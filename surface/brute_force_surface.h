// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "cloud/point_cloud.h"
#include "surface/surface_cloud.h"

// What queries of a SurfaceCloud mean, as octree/brute_force.h does for other queries.

namespace alidade::brute_force {

/// All points that answer a ray, in their order. spacings: by point id. layers: of an octree, with the
/// surfaces that discs require. Errors: those of queries; not as many spacings as points; discs without
/// surfaces. Cost: linear.
std::vector<Hit> find(const PointCloud& cloud, const Ray& ray, const SurfaceQuery& query,
                      std::span<const double> spacings, const PointLayers& layers = {});
/// The first of them.
std::optional<Hit> closest(const PointCloud& cloud, const Ray& ray, const SurfaceQuery& query,
                           std::span<const double> spacings, const PointLayers& layers = {});

}  // namespace alidade::brute_force
