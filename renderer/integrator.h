// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "renderer/light.h"
#include "renderer/sampler.h"
#include "renderer/world.h"

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

/// Follows light backwards along paths from the camera: at each surface light of sun, sky image and
/// emissive spheres is gathered, then a path continues in a direction its material chooses, at most
/// `max_bounces` + 1 times in all, the last time only to see whether sky or an emissive surface is there.
/// After a few bounces weak paths end by Russian roulette. The mean over samples is the radiance along the
/// ray, without bias but for `max_bounces`, the caustics left out in light.h, and this: a path that has been
/// scattered takes rough metal for at least as rough as the roughest surface before it (a diffuse one counts
/// as k_diffuse_roughness; each mirror or pane of glass on the way doubles it up to that), wherever it uses
/// the material. What is seen through a blur is blurred no less, so that no rare path brings a glint of the
/// sun as a speckle. Source: Kaplanyan and Dachsbacher, Path Space Regularization for Holistic and Robust
/// Light Transport, 2013.
///
/// Paths do not depend on one another. They advance together, surface by surface, since rays in batches are
/// answered several times faster: thousands of paths of neighbouring pixels are best. results: as many as
/// paths. `look`, if there is one, is called before each advance; what it throws ends the work.
void trace_paths(const World& world, const Lights& lights, std::span<const CameraPath> paths, int max_bounces,
                 std::span<PathResult> results, const std::function<void()>& look = {});

// Images without lights: one ray from the camera to the first surface, and for ambient occlusion one more.
// They show a cloud's shape and colours at once, with little noise. An emissive surface shows its radiance in
// all of them; others show the albedo that image layers have. A ray that meets nothing returns the visible
// sky, except in trace_flat, which returns black.

/// The metres that count as near in an image of ambient occlusion: those of the settings, else a twentieth
/// of the diagonal of visible_bounds(), infinite without points. 0 in other modes.
double ambient_occlusion_distance(const RenderSettings& settings, const LoadedCloud* cloud);

/// Colour times the share of directions, weighted by the cosine to the normal, that are free for
/// `ao_distance` metres (above 0, may be infinite): each path tries one direction, their mean is the share.
/// Within the last radius of a point before the limit its sphere may or may not count. Source: Zhukov, Iones
/// and Kronin, An Ambient Light Illumination Model, 1998; Landis, Production-Ready Global Illumination, 2002.
void trace_ambient_occlusion(const World& world, const Sky& sky, double ao_distance,
                             std::span<const CameraPath> paths, std::span<PathResult> results);

/// Colour times the cosine between normal and ray: what a lamp at the camera lights, without shadows and
/// equally bright near and far.
void trace_headlight(const World& world, const Sky& sky, std::span<const CameraPath> paths,
                     std::span<PathResult> results);

/// The colours themselves: for maps and masks.
void trace_flat(const World& world, std::span<const CameraPath> paths, std::span<PathResult> results);

/// What the camera paths bring back in the mode of the settings. results: as many as paths.
/// `ao_distance`: see ambient_occlusion_distance(); `look`: see trace_paths(), in other modes not called.
void trace_samples(const World& world, const Lights& lights, const RenderSettings& settings,
                   double ao_distance, std::span<const CameraPath> paths, std::span<PathResult> results,
                   const std::function<void()>& look = {});

}  // namespace alidade::renderer
