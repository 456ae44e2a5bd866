// SPDX-License-Identifier: MIT
#include "camera/projection.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <initializer_list>
#include <numbers>

namespace alidade::camera {
namespace {

void require(bool holds, const char* problem, const char* expected, double found) {
  if (!holds) throw input_error(problem, expected, fmt::format("{}", found));
}

void require_finite(std::initializer_list<double> numbers, const char* what) {
  for (const double number : numbers) require(std::isfinite(number), what, "", number);
}

void check_distortion(const Distortion& distortion) {
  constexpr const char* what = "a distortion parameter is not finite";
  require_finite({distortion.p1, distortion.p2}, what);
  for (const double each : distortion.radial) require_finite({each}, what);
  for (const double each : distortion.denominator) require_finite({each}, what);
  for (const double each : distortion.prism) require_finite({each}, what);
}

struct CheckLens {
  void operator()(const PinholeLens&) const {}
  void operator()(const OrthographicLens&) const {}
  void operator()(const EquirectangularLens&) const {}
  void operator()(const BrownLens& lens) const { check_distortion(lens.distortion); }
  void operator()(const FisheyeLens& lens) const { check_distortion(lens.distortion); }
  void operator()(const FieldOfViewLens& lens) const {
    require(std::fabs(lens.omega) < std::numbers::pi, "omega of the lens out of range",
            "radians between -pi and pi", lens.omega);
  }
  void operator()(const DivisionLens& lens) const {
    require_finite({lens.k}, "a distortion parameter is not finite");
  }
  void operator()(const UnifiedLens& lens) const {
    require(lens.alpha >= 0.0 && lens.alpha <= 1.0, "alpha of the lens out of range", "0 to 1", lens.alpha);
    require(lens.beta > 0.0 && std::isfinite(lens.beta), "beta of the lens out of range", "a positive number",
            lens.beta);
  }
  void operator()(const DualLens& lens) const {
    require(lens.transition >= 0.0 && lens.transition <= 1.0, "transition of the lens out of range", "0 to 1",
            lens.transition);
    check_distortion(lens.distortion);
  }
};

/// Whether a lens can fold over inside its view. The view of others ends with their half or whole sphere.
bool can_fold(const Lens& lens) {
  return std::holds_alternative<BrownLens>(lens) || std::holds_alternative<FisheyeLens>(lens) ||
         std::holds_alternative<DualLens>(lens) || std::holds_alternative<DivisionLens>(lens);
}

double angle_off_axis(const Projection& projection, const Ray& ray) {
  const glm::dvec3& forward = projection.camera().pose.forward;
  const double cosine =
      ray.direction.x * forward.x + ray.direction.y * forward.y + ray.direction.z * forward.z;
  return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / std::numbers::pi;
}

/// The share of the distance from the principal point to a pixel up to which the lens has a view.
double share_seen(const Projection& projection, const glm::dvec2& pixel) {
  const glm::dvec2 center(projection.camera().cx, projection.camera().cy);
  double seen = 0.0, unseen = 1.0;
  for (int step = 0; step < 50; ++step) {
    const double middle = 0.5 * (seen + unseen);
    (projection.ray(center + middle * (pixel - center)) ? seen : unseen) = middle;
  }
  return seen;
}

void check_fold_towards(const Projection& projection, const glm::dvec2& pixel) {
  if (projection.ray(pixel)) return;
  const Camera& camera = projection.camera();
  const glm::dvec2 center(camera.cx, camera.cy), way = pixel - center;
  const double share = share_seen(projection, pixel), distance = std::hypot(way.x, way.y);
  const std::optional<Ray> last = projection.ray(center + share * way);
  const double angle = last ? angle_off_axis(projection, *last) : 0.0;
  // A fisheye that covers the sphere has no view beyond its circle.
  if (std::holds_alternative<FisheyeLens>(camera.lens) && angle > 179.99) return;
  throw input_error(fmt::format("the distortion folds over at {:.6g} pixels from the principal point, {:.4g} "
                                "degrees off the axis",
                                share * distance, angle),
                    "a distortion model that is valid over the whole image",
                    fmt::format("an image pixel ({:g}, {:g}) at {:.6g} pixels", pixel.x, pixel.y, distance));
}

}  // namespace

std::optional<Ray> Projection::ray(const glm::dvec2& film_position) const {
  const std::optional<LensRay> seen = lens_.unproject(
      {(film_position.x - camera_.cx) / camera_.fx, (film_position.y - camera_.cy) / camera_.fy});
  if (!seen) return std::nullopt;
  const CameraPose& pose = camera_.pose;
  const glm::dvec3& towards = seen->direction;
  const glm::dvec3 direction = towards.x * pose.right + towards.y * pose.down + towards.z * pose.forward;
  glm::dvec3 origin = pose.position;
  if (seen->origin != glm::dvec3(0.0)) origin += seen->origin.x * pose.right + seen->origin.y * pose.down;
  return make_ray(origin, direction, camera_.near);
}

std::optional<glm::dvec2> Projection::project(const glm::dvec3& world) const {
  const glm::dvec3 offset = world - camera_.pose.position;
  const std::optional<glm::dvec2> film =
      lens_.project({glm::dot(offset, camera_.pose.right), glm::dot(offset, camera_.pose.down),
                     glm::dot(offset, camera_.pose.forward)});
  if (!film) return std::nullopt;
  return glm::dvec2(camera_.cx + camera_.fx * film->x, camera_.cy + camera_.fy * film->y);
}

void check_camera_numbers(const Camera& camera) {
  require(camera.width >= 1 && camera.width <= k_max_image_side, "image width out of range",
          "1 to 65536 pixels", camera.width);
  require(camera.height >= 1 && camera.height <= k_max_image_side, "image height out of range",
          "1 to 65536 pixels", camera.height);
  require(camera.fx > 0.0 && std::isfinite(camera.fx), "focal length out of range", "a positive number",
          camera.fx);
  require(camera.fy > 0.0 && std::isfinite(camera.fy), "focal length out of range", "a positive number",
          camera.fy);
  require_finite({camera.cx, camera.cy}, "the principal point is not finite");
  require(camera.near >= 0.0 && std::isfinite(camera.near), "near distance out of range", "0 or more",
          camera.near);
  for (const glm::dvec3& axis :
       {camera.pose.position, camera.pose.right, camera.pose.down, camera.pose.forward})
    require_finite({axis.x, axis.y, axis.z}, "the camera pose is not finite");
  std::visit(CheckLens{}, camera.lens);
}

void check_camera(const Camera& camera) {
  check_camera_numbers(camera);
  if (!can_fold(camera.lens)) return;

  // The view of a lens surrounds the principal point, so testing the image's border is enough; pixels inside
  // are tested for principal points outside the image.
  constexpr int k_steps = 64;
  const Projection projection(camera);
  for (int row = 0; row <= k_steps; ++row) {
    const bool on_border = row == 0 || row == k_steps;
    for (int column = 0; column <= k_steps; column += on_border || row % 8 == 0 ? 1 : k_steps) {
      check_fold_towards(projection, {static_cast<double>(camera.width) * column / k_steps,
                                      static_cast<double>(camera.height) * row / k_steps});
    }
  }
}

}  // namespace alidade::camera
