// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "base/progress.h"
#include "cloud/point_cloud.h"
#include "renderer/render.h"

namespace alidade {

/// Makes points that have been read ready to be traced, but for their radii: chooses their colours, frees the
/// columns that these do not need, builds the octree. `cloud` holds attributes_for(settings.color);
/// `attributes` are all that its files have, for messages. Errors: as choose_color().
LoadedCloud index_cloud(PointCloud&& cloud, AttributeSet attributes, const CloudSettings& settings,
                        const Progress& progress = {});

/// Chooses the radii of a cloud's points as its settings say: fills radius and spacing_factor, and measures
/// the spacings if radii adapt to the density and the octree has none for so many neighbours. `progress` is
/// in points measured. Errors: a radius, factor or number of neighbours out of range; adapted radii of only
/// some levels.
void choose_radius(const CloudSettings& settings, LoadedCloud& cloud, const Progress& progress = {});

/// A point in whose sphere a place lies.
struct SphereAround {
  std::uint64_t point_id = 0;
  double radius = 0.0;    ///< of its sphere, metres
  double distance = 0.0;  ///< of the place from its centre
};

/// The nearest such point; max_level as in RayQuery.
std::optional<SphereAround> sphere_around(const LoadedCloud& cloud, const glm::dvec3& place, int max_level);

}  // namespace alidade
