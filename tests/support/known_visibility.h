// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "cloud/point_cloud.h"
#include "octree/octree.h"
#include "simulation/site.h"

// Clouds sampled from exact surfaces, so that the truth about what is seen is known.

namespace alidade::test {

using namespace simulation;

struct KnownScene {
  std::string name;
  Site site;
  PointCloud cloud;                   ///< with noise
  std::vector<glm::dvec3> exact;      ///< where the points were before the noise, world
  std::vector<glm::dvec3> normals;    ///< of the surfaces there
  std::vector<glm::dvec3> observers;  ///< world
};

/// The courtyard with about so many points, as from stations in the yard and from the air; noise 3 mm.
KnownScene known_courtyard(std::size_t points);
/// A plate of 1 mm with points on both sides, 1 cm from each other; noise 0.1 mm.
KnownScene thin_plate();
/// Slats of 4 cm with gaps of 4 cm, and a wall 3 m behind; points 16 mm from each other, noise 1 mm.
KnownScene fence();
/// Trees of single leaves above ground; noise 2 mm.
KnownScene canopy();
/// A wall with 100 times the points on one half, and boxes behind it; noise 3 mm.
KnownScene mixed_density();
/// Ground that rises by 1 degree, seen along it from eye height, with a box on it; points 0.35 m from each
/// other, noise 2 cm.
KnownScene grazing_slope();

/// Which points of a scene the observer sees, 1 or 0: nothing of the site blocks the line to the position a
/// tenth of a millimetre above the point's exact position, on the observer's side. (Both sides of a leaf
/// without thickness are the leaf.)
std::vector<std::uint8_t> truth(const KnownScene& scene, const glm::dvec3& observer);

/// Points that have a point of the other answer within two radii of their discs: they lie on the boundary of
/// what is seen. octree: of the scene's cloud, with spacings.
std::vector<std::uint8_t> near_boundary(const KnownScene& scene, const Octree& octree,
                                        const std::vector<std::uint8_t>& truth);

/// Those of near_boundary, and points whose free line of sight passes an edge of something else within two
/// radii of that one's discs: it crosses the exact plane of a point so near to the point. Behind such an edge
/// the boundary of the visible part is as wide as the lines spread. Only every `step`-th point is tested,
/// since the queries are slow; all others count as near a boundary.
std::vector<std::uint8_t> near_boundary_or_edge(const KnownScene& scene, const Octree& octree,
                                                const std::vector<std::uint8_t>& truth,
                                                const glm::dvec3& observer, std::size_t step);

/// How an answer compares with the truth.
struct Agreement {
  double all = 0.0;        ///< share of the points with the right answer
  double clear = 0.0;      ///< the same without points near the boundary
  double precision = 0.0;  ///< of points said to be seen, share that is; not near the boundary
  double recall = 0.0;     ///< of points that are seen, share said to be; not near the boundary
};
Agreement agreement(const std::vector<std::uint8_t>& seen, const std::vector<std::uint8_t>& truth,
                    const std::vector<std::uint8_t>& near_boundary);

}  // namespace alidade::test
