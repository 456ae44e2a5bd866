// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "renderer/integrator.h"

// Pictures without lights: one ray from the camera to the first surface, and for ambient occlusion one more.
// They show a cloud's shape and colours at once, with little noise. A surface that shines by itself shows its
// radiance in all of them; others show the albedo that image layers have. A ray that meets nothing brings the
// sky as it is seen, but for trace_flat, which brings black.

namespace alidade::renderer {

/// The metres that count as near in a picture of ambient occlusion: those of the settings, else a twentieth
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

/// What the camera paths bring back in the mode that the settings ask for. results: as many as paths.
/// `ao_distance`: see ambient_occlusion_distance().
void trace_samples(const World& world, const Lights& lights, const RenderSettings& settings,
                   double ao_distance, std::span<const CameraPath> paths, std::span<PathResult> results);

}  // namespace alidade::renderer
