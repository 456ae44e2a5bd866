// SPDX-License-Identifier: MIT
#include "camera/camera_path.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "base/bounds.h"
#include "base/error.h"
#include "base/exact_math.h"

namespace alidade::camera {
namespace {

/// The values of a camera that are interpolated.
struct Knot {
  glm::dvec3 position{0.0}, forward{0.0}, down{0.0};
  glm::dvec2 focal{0.0}, middle{0.0};
};

Knot operator*(double weight, const Knot& knot) {
  return {weight * knot.position, weight * knot.forward, weight * knot.down, weight * knot.focal,
          weight * knot.middle};
}

Knot operator+(const Knot& a, const Knot& b) {
  return {a.position + b.position, a.forward + b.forward, a.down + b.down, a.focal + b.focal,
          a.middle + b.middle};
}

Knot knot_of(const Camera& camera) {
  return {camera.pose.position,
          camera.pose.forward,
          camera.pose.down,
          {camera.fx, camera.fy},
          {camera.cx, camera.cy}};
}

/// The distance between two keyframes: that of their positions, plus a share of the turn, so that a camera
/// that only turns takes time, too.
double step_between(const Knot& a, const Knot& b, double turning_length) {
  const double turn = glm::length(a.forward - b.forward) + glm::length(a.down - b.down);
  return glm::length(a.position - b.position) + turning_length * turn;
}

/// The knot at `time` between b and c, whose neighbours are a and d; times are those of the four.
/// Source: Barry and Goldman, SIGGRAPH 1988: a Catmull-Rom spline as a pyramid of linear interpolations.
Knot spline(const Knot (&knots)[4], const double (&times)[4], double time) {
  const auto between = [&](const Knot& a, const Knot& b, double from, double to) {
    const double share = (time - from) / (to - from);
    return (1.0 - share) * a + share * b;
  };
  const Knot ab = between(knots[0], knots[1], times[0], times[1]),
             bc = between(knots[1], knots[2], times[1], times[2]),
             cd = between(knots[2], knots[3], times[2], times[3]);
  return between(between(ab, bc, times[0], times[2]), between(bc, cd, times[1], times[3]), times[1],
                 times[2]);
}

/// The path through all knots, by a time that grows from knot to knot.
class Path {
 public:
  explicit Path(std::span<const Camera> keyframes) {
    for (const Camera& camera : keyframes) knots_.push_back(knot_of(camera));
    double length = 0.0;
    for (std::size_t i = 1; i < knots_.size(); ++i)
      length += glm::length(knots_[i].position - knots_[i - 1].position);
    turning_ = length > 0.0 ? 0.25 * length / static_cast<double>(knots_.size()) : 1.0;
    times_.push_back(0.0);
    for (std::size_t i = 1; i < knots_.size(); ++i) {
      // Centripetal: the root of the distance. Equal keyframes still need a time between them.
      const double step = std::sqrt(step_between(knots_[i - 1], knots_[i], turning_));
      times_.push_back(times_.back() + std::max(step, 1e-6));
    }
  }

  double end() const { return times_.back(); }

  Knot at(double time) const {
    const auto next = std::upper_bound(times_.begin() + 1, times_.end() - 1, time);
    const auto i = static_cast<std::size_t>(next - times_.begin());
    // Beyond its ends the path is straight.
    const std::size_t last = knots_.size() - 1;
    const Knot before = i >= 2 ? knots_[i - 2] : 2.0 * knots_[i - 1] + -1.0 * knots_[i];
    const Knot after = i < last ? knots_[i + 1] : 2.0 * knots_[i] + -1.0 * knots_[i - 1];
    const double step = times_[i] - times_[i - 1];
    const double time_before = i >= 2 ? times_[i - 2] : times_[i - 1] - step,
                 time_after = i < last ? times_[i + 1] : times_[i] + step;
    return spline({before, knots_[i - 1], knots_[i], after},
                  {time_before, times_[i - 1], times_[i], time_after}, time);
  }

  double step(const Knot& a, const Knot& b) const { return step_between(a, b, turning_); }
  std::size_t size() const { return knots_.size(); }

 private:
  std::vector<Knot> knots_;
  std::vector<double> times_;
  double turning_ = 0.0;  ///< metres that count as much as a turn by one radian
};

Camera camera_at(const Knot& knot, const Camera& like) {
  Camera camera = like;
  camera.fx = knot.focal.x, camera.fy = knot.focal.y;
  camera.cx = knot.middle.x, camera.cy = knot.middle.y;
  camera.pose = look_at(knot.position, knot.position + knot.forward, -knot.down);
  return camera;
}

}  // namespace

std::vector<Camera> orbit_cameras(std::span<const glm::dvec3> positions, int width, int height, int count) {
  // The cylinder that the positions sweep while they turn.
  constexpr int k_sides = 64;
  Bounds bounds;
  for (const glm::dvec3& position : positions) bounds.grow(position);
  const glm::dvec3 center = bounds.center(), half = 0.5 * bounds.size();
  double radius = 0.0;
  for (const glm::dvec3& position : positions)
    radius = std::max(radius, glm::length(glm::dvec2(position - center)));
  std::vector<glm::dvec3> swept;
  for (int i = 0; i < k_sides; ++i) {
    const SineCosine side = sine_cosine_of_degrees(360.0 * i / k_sides);
    for (const double above : {-half.z, half.z})
      swept.push_back(center + glm::dvec3(radius * side.cosine, radius * side.sine, above));
  }
  const Camera first = overview_camera(swept, 0.0, width, height);
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    const SineCosine turn = sine_cosine_of_degrees(360.0 * i / count);
    const auto turned = [&](const glm::dvec3& v) {
      return glm::dvec3(turn.cosine * v.x - turn.sine * v.y, turn.sine * v.x + turn.cosine * v.y, v.z);
    };
    Camera& camera = cameras.emplace_back(first);
    camera.pose = {.position = center + turned(first.pose.position - center),
                   .right = turned(first.pose.right),
                   .down = turned(first.pose.down),
                   .forward = turned(first.pose.forward)};
  }
  return cameras;
}

std::vector<Camera> cameras_between(std::span<const Camera> keyframes, int count) {
  const Camera& like = keyframes.front();
  for (const Camera& camera : keyframes) {
    check_that(camera.width == like.width && camera.height == like.height &&
                   camera.lens.index() == like.lens.index(),
               "keyframes of different sizes or lenses", "one size and lens for all keyframes");
  }
  const Path path(keyframes);
  // Times at equal distances, from a table of lengths along the path.
  constexpr std::size_t k_steps_per_knot = 64;
  const std::size_t steps = k_steps_per_knot * (path.size() - 1);
  std::vector<double> lengths{0.0};
  Knot before = path.at(0.0);
  for (std::size_t i = 1; i <= steps; ++i) {
    const Knot next = path.at(path.end() * static_cast<double>(i) / static_cast<double>(steps));
    lengths.push_back(lengths.back() + path.step(before, next));
    before = next;
  }
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    const double wanted = lengths.back() * i / (count - 1);
    const auto next = std::lower_bound(lengths.begin() + 1, lengths.end() - 1, wanted);
    const auto step = static_cast<std::size_t>(next - lengths.begin());
    const double within = lengths[step] - lengths[step - 1];
    const double share = within > 0.0 ? std::min((wanted - lengths[step - 1]) / within, 1.0) : 0.0;
    const double time = path.end() * (static_cast<double>(step - 1) + share) / static_cast<double>(steps);
    cameras.push_back(camera_at(path.at(time), like));
  }
  return cameras;
}

}  // namespace alidade::camera
