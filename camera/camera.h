// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "base/bounds.h"
#include "base/ray.h"
#include "renderer/scene.h"

namespace alidade {

/// Ray through a place on the film, in pixels ((0.5, 0.5) = centre of the top left pixel). Starts at the
/// camera, t_min = 0. Unit direction. For many rays of one camera make a Projection (renderer/camera/
/// projection.h). Errors: the lens has no view through this place.
Ray camera_ray(const Camera& camera, const glm::dvec2& film_position);

/// Film position of a world point in pixels (may lie outside the image); empty if the lens does not see it,
/// as when it lies in or behind the camera's plane.
std::optional<glm::dvec2> project_to_film(const Camera& camera, const glm::dvec3& world);

/// Pose that looks from `eye` to `target` with `up` towards the top of the image.
/// Errors: eye and target coincide, up is zero or parallel to the view.
CameraPose look_at(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up = {0, 0, 1});

/// Pinhole from a vertical field of view in degrees, (0, 180); square pixels, principal point in the middle.
Camera pinhole_from_fov(int width, int height, double vertical_fov, const CameraPose& pose);

/// The same camera for another image size: the vertical field of view is kept, the principal point scales
/// along; a panorama stays whole.
Camera resized(const Camera& camera, int width, int height);

/// A view of the whole box: three-quarter from above (from the south-west, 30 degrees down), filling the
/// image.
Camera overview_camera(const Bounds& bounds, int width, int height);

/// Everything around a place: the whole sphere, the middle of the image looks north (+y), east (+x) is to the
/// right of it. Column x of the image looks to azimuth 360 (x / width - 1/2) degrees, clockwise from north.
Camera panorama_camera(const glm::dvec3& place, int width, int height);

/// The box from straight above through parallel rays: north up, the borders of pixels at whole multiples of
/// the resolution (metres), the rays start just above the box. Errors: a resolution that is not above 0; more
/// pixels than an image may have; an empty box.
Camera orthophoto_camera(const Bounds& bounds, double resolution);

}  // namespace alidade
