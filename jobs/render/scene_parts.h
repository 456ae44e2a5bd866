// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "jobs/listener.h"
#include "jobs/render/render_plan.h"
#include "renderer/load_cloud.h"
#include "renderer/scene.h"

// What a scene names, read from its files.

namespace alidade::jobs {

/// Reads the meshes of a scene, and notes their sizes. Errors: as read_mesh().
void load_meshes(renderer::Scene& scene, Listener& listener);

/// Reads the image of the scene's sky, if it has one and its mode shows it. Errors: as read_sky_image(),
/// naming the scene file.
void load_sky(renderer::Scene& scene, const std::filesystem::path& scene_file, Listener& listener);

/// Loads the cloud of the plan's scene, which has one, and notes its colours and radii. Errors: those of
/// renderer::load_cloud(); coordinates in degrees; of a database, its own.
renderer::LoadedCloud load_scene_cloud(const RenderPlan& plan, Listener& listener);

/// Completes the scene's light by its cloud (may be null), as far as its mode needs it, and notes how:
/// computes the position of a sun by time, which is left out below the horizon, and the distance of ambient
/// occlusion. Errors: as place_sun().
void complete_light(renderer::Scene& scene, const renderer::LoadedCloud* cloud, Listener& listener);

}  // namespace alidade::jobs
