// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "base/bounds.h"
#include "base/ray.h"
#include "camera/lens.h"

namespace alidade::camera {

/// The axes of a camera's own frame.
enum class AxisConvention {
  opencv,  ///< +x right, +y down, +z forward
  opengl,  ///< +x right, +y up, +z backward
};

/// Camera frame -> world, right-handed, rotation orthonormal: columns right, down, forward (opencv), then the
/// position.
struct CameraPose {
  glm::dvec3 position{0.0};
  glm::dvec3 right{1.0, 0.0, 0.0};
  glm::dvec3 down{0.0, 0.0, -1.0};
  glm::dvec3 forward{0.0, 1.0, 0.0};
};

/// A camera. Pixel (0,0) is top left, its centre at (0.5, 0.5). The lens maps a direction to a film position
/// (x, y), which is (cx + fx x, cy + fy y) in pixels; see camera/lens.h.
struct Camera {
  int width = 600, height = 400;
  double fx = 0.0, fy = 0.0;  ///< focal lengths in pixels; orthographic: pixels per metre; equirectangular:
                              ///< pixels per radian
  double cx = 0.0, cy = 0.0;  ///< principal point, where the axis meets the film, in pixels
  CameraPose pose;
  Lens lens = PinholeLens{};
  double near = 0.0;  ///< points at a smaller distance along a ray are not seen
};

// Largest image that scene files and command lines may request, inclusive.

inline constexpr int k_max_image_side = 1 << 16;         ///< pixels
inline constexpr std::uint64_t k_max_pixels = 1u << 28;  ///< width times height

/// Ray through a position on the film, in pixels ((0.5, 0.5) = centre of the top left pixel). Starts at the
/// camera, t_min = near. Unit direction. For many rays of one camera make a Projection
/// (camera/projection.h). Errors: the lens has no view through this position.
Ray camera_ray(const Camera& camera, const glm::dvec2& film_position);

/// Film position of a world point in pixels (may lie outside the image); empty if the lens does not see it,
/// as when it lies in or behind the camera's plane.
std::optional<glm::dvec2> project_to_film(const Camera& camera, const glm::dvec3& world);

/// Pose that looks from `eye` to `target` with `up` towards the top of the image.
/// Errors: eye and target coincide, up is zero or parallel to the view.
CameraPose look_at(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up = {0, 0, 1});

/// Pinhole from a vertical field of view in degrees, (0, 180); square pixels, principal point in the middle.
Camera pinhole_from_fov(int width, int height, double vertical_fov, const CameraPose& pose);

/// A camera for another image size: the vertical field of view is kept, the principal point scales along, and
/// a panorama keeps all directions.
Camera resized(const Camera& camera, int width, int height);

/// A pinhole at this pose whose image some positions fill; its principal point is moved for that. Empty if a
/// position is not before the camera, or more than 75 degrees off its axis.
std::optional<Camera> filled_camera(const CameraPose& pose, std::span<const glm::dvec3> positions, int width,
                                    int height);

/// A view of the whole box: three-quarter from above (from the south-west, 30 degrees down), filling the
/// image.
Camera overview_camera(const Bounds& bounds, int width, int height);

/// A view of positions from above, 30 degrees down: they and what lies at most `radius` around them fill the
/// image. `azimuth`: of the viewing direction, degrees clockwise from north (+y).
Camera overview_camera(std::span<const glm::dvec3> positions, double radius, int width, int height,
                       double azimuth = 45.0);

/// A camera that sees the whole sphere around a position: the middle of the image faces north (+y), east (+x)
/// is right of it. Column x of the image has the azimuth 360 (x / width - 1/2) degrees, clockwise from north.
Camera panorama_camera(const glm::dvec3& position, int width, int height);

/// An orthographic camera straight above the box: north up, the borders of pixels at whole multiples of the
/// resolution (metres), the rays start just above the box. Errors: a resolution that is not above 0; more
/// pixels than an image may have; an empty box.
Camera orthophoto_camera(const Bounds& bounds, double resolution);

/// Deviation of the columns from orthonormal ones: the largest entry of |R^T R - I|.
double error_of_rotation(const glm::dmat3& rotation);

/// Makes a matrix that is nearly a rotation orthonormal. The third column keeps its direction.
glm::dmat3 orthonormal(const glm::dmat3& rotation);

/// Rotation by a quaternion w, x, y, z of any length (Hamilton's convention). Empty if its length is 0, not
/// finite, or beyond 1e-100 to 1e100.
std::optional<glm::dmat3> rotation_from_quaternion(const std::array<double, 4>& quaternion);

/// Rotation about an axis by its length in radians, counter-clockwise seen from the tip. Source: Rodrigues.
/// Requires: finite, at most 1e6 long.
glm::dmat3 rotation_from_axis_angle(const glm::dvec3& axis);

/// From camera = rotation * world + translation, with camera axes right, down, forward.
CameraPose pose_from_world_to_camera(const glm::dmat3& rotation, const glm::dvec3& translation);

/// The ground transform of an image from straight above: world x = [0] + [1] column + [2] row, y = [3] +
/// [4] column + [5] row, with (0, 0) the outer corner of the first pixel. Errors: the camera's rays are not
/// parallel, or do not point straight down.
std::array<double, 6> ground_transform(const Camera& camera);

}  // namespace alidade::camera
