// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "camera/camera.h"
#include "renderer/load_cloud.h"
#include "renderer/scene.h"

// The default light, camera and brightness of images.

namespace alidade::renderer {

/// The background of such images, which no light comes from: a light blue.
inline constexpr Rgb k_overview_background{0.87f, 0.91f, 0.95f};
/// Enough samples for an overview.
inline constexpr int k_overview_samples = 16;

/// Sun and sky of a clear day, and the clouds of these files as surfaces; no cloud without files.
Scene daylight_scene(std::vector<std::filesystem::path> files);

/// The view of the whole cloud, by its points and not their box, whose corners are often empty:
/// camera::overview_camera() of visible_positions(). From the scanners' side where most of the points are to
/// one side of them; a single depth camera's frame as that camera saw it. Requires points.
camera::Camera overview_camera(const LoadedCloud& cloud, int width, int height);

/// Moves the sun of a scene behind the camera, up and to the right, if overview_camera() is on the scanners'
/// side: what a scanner saw faces it, and must not lie in its own shadow. Whole degrees.
void light_from_scanners(Scene& scene, const LoadedCloud& cloud, const camera::Camera& view);

/// The exposure, in stops, that gives the surfaces in a view a medium brightness: half of their pixels are
/// darker than 0.47 of white as displayed, half brighter. It is that of an image whose longer side has at
/// most 96 pixels, so that it is the same for every part and size of an image; within 4 stops of 0. 0 where
/// the view has no surfaces. The scene's light is prepared. Cost: that of the small image.
double automatic_exposure(const Scene& scene, const LoadedCloud* cloud, const camera::Camera& view);

}  // namespace alidade::renderer
