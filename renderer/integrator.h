// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include "renderer/light.h"
#include "renderer/sampler.h"
#include "renderer/surface.h"

namespace alidade::renderer {

/// A path about to begin.
struct CameraPath {
  Ray ray;
  Sampler sampler;
};

/// What one path brings back.
struct PathResult {
  Rgb radiance{0.0f};
  bool met_surface = false;     ///< whether the camera ray met anything
  std::uint64_t ray_count = 0;  ///< path and shadow rays
};

/// First dimension of the sampler that paths use; those below belong to the camera.
constexpr std::uint32_t k_first_path_dimension = 2;

/// Roughness that metal has at least on a path which a diffuse surface has scattered.
constexpr double k_diffuse_roughness = 0.5;

/// Follows light backwards along paths from the camera: at each surface light of sun, sky picture and
/// emissive spheres is gathered, then a path goes on in a direction its material chooses, at most
/// `max_bounces` + 1 times in all, the last time only to see whether sky or an emissive surface is there.
/// After a few bounces weak paths end by Russian roulette. The mean over samples is the radiance along the
/// ray, without bias but for `max_bounces`, the caustics left out in light.h, and this: a path that has been
/// scattered takes rough metal for at least as rough as the roughest surface before it (a diffuse one counts
/// as k_diffuse_roughness; each mirror or pane of glass on the way doubles it up to that), in all it asks of
/// the material. What is seen through a blur is blurred no less, so that no rare path brings a glint of the
/// sun as a speckle. Source: Kaplanyan and Dachsbacher, Path Space Regularization for Holistic and Robust
/// Light Transport, 2013.
///
/// Paths do not depend on one another. They advance together, surface by surface, since rays in batches are
/// answered several times faster: a few thousand paths of neighbouring pixels are best. results: as many as
/// paths.
void trace_paths(const World& world, const Lights& lights, std::span<const CameraPath> paths, int max_bounces,
                 std::span<PathResult> results);

}  // namespace alidade::renderer
