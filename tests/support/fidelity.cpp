// SPDX-License-Identifier: MIT
#include "tests/support/fidelity.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <random>

#include "base/color.h"
#include "cloud/lattice.h"
#include "compare/metrics/errors.h"
#include "compare/metrics/flip.h"
#include "compare/metrics/ssim.h"
#include "renderer/read_scene.h"
#include "renderer/render.h"
#include "simulation/courtyard.h"

namespace alidade::test {
namespace {

constexpr double k_jump = 0.5;        // metres of depth that make a silhouette
constexpr double k_off_plane = 0.05;  // metres from a pixel's plane to its neighbour that make a border
constexpr double k_far_off = 0.1;     // metres

const std::vector<image::Layer> k_layers = {image::Layer::color, image::Layer::depth, image::Layer::normal,
                                            image::Layer::position};
const std::vector<image::Layer> k_sigma = {image::Layer::depth_sigma};

bool sees(const image::Film& film, std::size_t pixel) {
  return std::isfinite(film.depth[pixel]);
}

/// Whether a neighbour lies off the plane of a pixel's surface.
bool is_border(const image::Film& truth, std::size_t pixel, std::size_t neighbour) {
  if (!sees(truth, pixel) || !sees(truth, neighbour)) return true;
  const glm::dvec3 way = truth.position[neighbour] - truth.position[pixel];
  return std::fabs(glm::dot(way, glm::dvec3(truth.normal[pixel]))) > k_off_plane;
}

/// Which pixels have no border within two pixels.
std::vector<std::uint8_t> interior_of(const image::Film& truth) {
  const auto beside = [&](int x, int y, const auto& holds) {
    for (int v = std::max(y - 1, 0); v <= std::min(y + 1, truth.height - 1); ++v)
      for (int u = std::max(x - 1, 0); u <= std::min(x + 1, truth.width - 1); ++u)
        if (holds(truth.index(u, v))) return true;
    return false;
  };
  std::vector<std::uint8_t> border(truth.count()), interior(truth.count());
  for (int y = 0; y < truth.height; ++y)
    for (int x = 0; x < truth.width; ++x)
      border[truth.index(x, y)] =
          beside(x, y, [&](std::size_t other) { return is_border(truth, truth.index(x, y), other); });
  for (int y = 0; y < truth.height; ++y)
    for (int x = 0; x < truth.width; ++x)
      interior[truth.index(x, y)] = !beside(x, y, [&](std::size_t other) { return border[other] != 0; });
  return interior;
}

/// Metres of silhouettes: a pixel's width at the nearer depth for each pair of neighbours that a jump parts.
double silhouette_length(const image::Film& truth, double focal) {
  double length = 0.0;
  const auto add = [&](std::size_t a, std::size_t b) {
    const double near = std::min(truth.depth[a], truth.depth[b]),
                 far = std::max(truth.depth[a], truth.depth[b]);
    if (!std::isfinite(near) || !(far - near > k_jump)) return;
    if (is_border(truth, truth.depth[a] == near ? a : b, truth.depth[a] == near ? b : a))
      length += near / focal;
  };
  for (int y = 0; y < truth.height; ++y) {
    for (int x = 0; x < truth.width; ++x) {
      if (x + 1 < truth.width) add(truth.index(x, y), truth.index(x + 1, y));
      if (y + 1 < truth.height) add(truth.index(x, y), truth.index(x, y + 1));
    }
  }
  return length;
}

/// The value that a share of them do not exceed; 0 of none.
double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return 0.0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

compare::ComparedImage displayed(const image::Film& film, double exposure) {
  compare::ComparedImage image;
  image.width = film.width;
  image.height = film.height;
  image.color_channels = 3;
  const float gain = static_cast<float>(std::exp2(exposure));
  for (const Rgb& color : film.color)
    for (int channel = 0; channel < 3; ++channel)
      image.color.push_back(
          static_cast<float>(srgb_from_linear(std::clamp(gain * color[channel], 0.0f, 1.0f))));
  return image;
}

}  // namespace

const std::shared_ptr<const simulation::Site>& exact_courtyard() {
  static const auto site = std::make_shared<const simulation::Site>(simulation::courtyard());
  return site;
}

PointCloud courtyard_cloud(const ScanQuality& quality) {
  const simulation::Site& site = *exact_courtyard();
  simulation::ScanOptions options = simulation::courtyard_scan(quality.points, 1);
  if (quality.noise > 0.0) options.terrestrial.range_noise = options.drone.range_noise = quality.noise;
  PointCloud cloud = simulation::scan_header(site);
  simulation::scan(site, options, [&](const PointCloud& batch) {
    cloud.positions.insert(cloud.positions.end(), batch.positions.begin(), batch.positions.end());
    cloud.colors.insert(cloud.colors.end(), batch.colors.begin(), batch.colors.end());
  });
  std::mt19937_64 random(1);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const Bounds bounds = cloud.bounds();
  const auto strays = static_cast<std::size_t>(quality.stray_share * static_cast<double>(quality.points));
  for (std::size_t i = 0; i < strays; ++i) {
    const glm::dvec3 share(unit(), unit(), unit());
    cloud.positions.push_back(*to_lattice(cloud.lattice, bounds.min + bounds.size() * share));
    cloud.colors.push_back(Color16(static_cast<std::uint16_t>(random())));
  }
  return cloud;
}

std::vector<FidelityView> fidelity_views(int width) {
  const glm::dvec3 zero = exact_courtyard()->origin();
  const auto view = [&](double fov, const glm::dvec3& eye, const glm::dvec3& target) {
    return camera::pinhole_from_fov(width, width * 2 / 3, fov, camera::look_at(zero + eye, zero + target));
  };
  return {{"yard", view(56, {23, -15.2, 6.8}, {-5, 2.5, 1.2})},
          {"eye", view(50, {9, -9, 1.7}, {1, 0, 1.0})},
          {"drone", view(45, {45, -45, 40}, {0, 0, 3})}};
}

renderer::Scene courtyard_light() {
  renderer::Scene scene = renderer::read_scene(ALIDADE_SOURCE_FOLDER "/scenes/courtyard.json");
  scene.cloud.reset();
  scene.camera.reset();
  return scene;
}

image::Film exact_image(renderer::Scene scene) {
  scene.objects.emplace_back(renderer::Model{exact_courtyard(), "courtyard"});
  return renderer::render(scene, nullptr, {.layers = k_layers});
}

image::Film image_of(renderer::Scene scene, const renderer::LoadedCloud& cloud, double* seconds) {
  const auto start = std::chrono::steady_clock::now();
  image::Film film = renderer::render(scene, &cloud, {.layers = k_layers});
  if (seconds) *seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  scene.render.samples = 1;
  film.depth_sigma = renderer::render(scene, &cloud, {.layers = k_sigma}).depth_sigma;
  return film;
}

Fidelity fidelity(const camera::Camera& camera, const image::Film& truth, const image::Film& film,
                  double exposure) {
  std::vector<double> differences, interior_differences, angles, sigmas;
  const std::vector<std::uint8_t> interior = interior_of(truth);
  std::size_t true_pixels = 0, missing = 0, far_off = 0, surprises = 0;
  double grown_area = 0.0;
  for (std::size_t pixel = 0; pixel < truth.count(); ++pixel) {
    const double true_depth = truth.depth[pixel], depth = film.depth[pixel];
    true_pixels += sees(truth, pixel);
    missing += sees(truth, pixel) && depth > true_depth + k_jump;
    if (depth < true_depth - k_jump) grown_area += depth * depth / (camera.fx * camera.fy);
    if (!sees(truth, pixel) || !sees(film, pixel)) continue;
    differences.push_back(std::fabs(depth - true_depth));
    far_off += differences.back() > k_far_off;
    if (!film.depth_sigma.empty()) {
      sigmas.push_back(film.depth_sigma[pixel]);
      surprises += differences.back() > 3.0 * sigmas.back();
    }
    if (interior[pixel] == 0) continue;
    interior_differences.push_back(differences.back());
    const double cosine = glm::dot(glm::dvec3(truth.normal[pixel]), glm::dvec3(film.normal[pixel]));
    angles.push_back(glm::degrees(std::acos(std::clamp(cosine, -1.0, 1.0))));
  }
  Fidelity result;
  const auto share = [](std::size_t part, std::size_t all) {
    return all == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(all);
  };
  result.far_off = share(far_off, differences.size());
  result.surprises = share(surprises, differences.size());
  result.sigma_median = quantile(sigmas, 0.5);
  result.depth_median = quantile(differences, 0.5);
  result.depth_p95 = quantile(differences, 0.95);
  result.interior_p95 = quantile(interior_differences, 0.95);
  result.normal_median = quantile(angles, 0.5);
  const double length = silhouette_length(truth, camera.fx);
  result.grown = length > 0.0 ? grown_area / length : 0.0;
  result.holes = share(missing, true_pixels);
  const compare::ComparedImage reference = displayed(truth, exposure), test = displayed(film, exposure);
  result.flip = compare::flip(reference, test).mean;
  result.ssim = compare::similarity(reference, test).ssim;
  result.psnr = compare::error_metrics(reference, test, compare::ColorEncoding::display).psnr;
  return result;
}

}  // namespace alidade::test
