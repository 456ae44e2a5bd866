// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>

#include "camera/camera.h"
#include "image/film.h"
#include "renderer/load_cloud.h"
#include "simulation/site.h"

// Measures how far images of a scan are from images of the site that was scanned: camera, integrator and
// random numbers are equal, and only the answers to rays differ.

namespace alidade::test {

/// The courtyard, made once.
const std::shared_ptr<const simulation::Site>& exact_courtyard();

struct ScanQuality {
  std::uint64_t points = 1'000'000;
  double noise = 0.0;        ///< standard deviation along the beam, metres; 0: the scanners' own, 1.5 to 6 mm
  double stray_share = 0.0;  ///< points anywhere in the site's bounds, of all
};

/// A scan of the courtyard with colours.
PointCloud courtyard_cloud(const ScanQuality& quality);

/// The views that fidelity is measured in, 3:2: the whole yard, benches and a lamp from eye level, and the
/// roofs from a drone.
struct FidelityView {
  const char* name;
  camera::Camera camera;
};
std::vector<FidelityView> fidelity_views(int width);

/// The scene of the courtyard (scenes/courtyard.json) without a cloud or a camera.
renderer::Scene courtyard_light();

/// An image of the site or of a scan: colour, depth, normals, positions, and sigma of the depth. `scene` has
/// a camera. seconds: of rendering all but sigma.
image::Film exact_image(renderer::Scene scene);
image::Film image_of(renderer::Scene scene, const renderer::LoadedCloud& cloud, double* seconds = nullptr);

struct Fidelity {
  // Over the pixels whose centres see a surface in both images.
  double depth_median = 0.0, depth_p95 = 0.0;  ///< of absolute differences, metres
  double far_off = 0.0;                        ///< share of differences above 10 cm
  double surprises = 0.0;                      ///< share of differences above 3 sigma of the image
  double sigma_median = 0.0;                   ///< metres
  // Over interior pixels only: neither they nor the eight around them are beside a jump of the true depth.
  double interior_p95 = 0.0;   ///< metres
  double normal_median = 0.0;  ///< angle between normals, degrees
  /// How much thicker silhouettes are than in truth, metres: the area, at its own depth, that is more than
  /// half a metre nearer than the truth, over the length of the true silhouettes. To be read as a ratio.
  double grown = 0.0;
  /// Share of the true surface where the image has nothing, or something more than half a metre behind.
  double holes = 0.0;
  // Of the colours as a display shows them.
  double flip = 0.0, ssim = 0.0, psnr = 0.0;
};

/// exposure: stops. Requires: both films of `camera`, a pinhole.
Fidelity fidelity(const camera::Camera& camera, const image::Film& truth, const image::Film& film,
                  double exposure);

}  // namespace alidade::test
