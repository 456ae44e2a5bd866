// SPDX-License-Identifier: MIT
#include "renderer/light.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/error.h"

namespace alidade::renderer {
namespace {

/// Height of the cap of directions under which a sphere is seen; 2, all of them, from inside.
double cap_height(const Sphere& sphere, const glm::dvec3& position) {
  const glm::dvec3 offset = sphere.center - position;
  const double sine_sq = sphere.radius * sphere.radius / glm::dot(offset, offset);
  if (!(sine_sq < 1.0)) return 2.0;
  return sine_sq / (1.0 + std::sqrt(1.0 - sine_sq));
}

}  // namespace

Lights::Lights(const Scene& scene) : sky_(&scene.sky) {
  if (scene.sun_by_time) throw Error({.problem = "the position of the scene's sun has not been computed"});
  if (const auto* image_sky = std::get_if<ImageSky>(&scene.sky)) {
    if (!image_sky->image) throw file_error(image_sky->file, "the image of the sky has not been read");
    if (!image_sky->image->is_black()) sky_image_ = image_sky->image.get();
  }
  if (scene.sun) sun_.emplace(*scene.sun);
  double total = 0.0;
  for (std::size_t index = 0; index < scene.objects.size(); ++index) {
    const auto* sphere = std::get_if<Sphere>(&scene.objects[index]);
    const auto* emissive = sphere ? std::get_if<Emissive>(&sphere->material) : nullptr;
    if (emissive == nullptr) continue;
    const Rgb& radiance = emissive->radiance;
    const double power = sphere->radius * sphere->radius * (double{radiance.r} + radiance.g + radiance.b);
    if (!(power > 0.0)) continue;
    total += power;
    spheres_.push_back({index, *sphere, radiance, power, total});
  }
  for (SphereLight& light : spheres_) {
    light.chance /= total;
    light.cumulative /= total;
  }
}

LightSample Lights::sample(const glm::dvec3& position, double u_choice, const glm::dvec2& u) const {
  const auto chosen = std::find_if(spheres_.begin(), spheres_.end() - 1,
                                   [&](const SphereLight& light) { return u_choice < light.cumulative; });
  const double height = cap_height(chosen->sphere, position);
  const glm::dvec3 offset = chosen->sphere.center - position;
  const double distance = glm::length(offset);
  const Basis basis = basis_around(distance > 0.0 ? offset / distance : glm::dvec3(0.0, 0.0, 1.0));
  return {chosen->object, basis.to_world(sample_cone(u, height)), chosen->radiance,
          chosen->chance * pdf_cone(height)};
}

const Lights::SphereLight* Lights::find(std::size_t object) const {
  const auto found = std::find_if(spheres_.begin(), spheres_.end(),
                                  [&](const SphereLight& light) { return light.object == object; });
  return found == spheres_.end() ? nullptr : &*found;
}

double Lights::pdf(std::size_t object, const glm::dvec3& position) const {
  const SphereLight* light = find(object);
  return light == nullptr ? 0.0 : light->chance * pdf_cone(cap_height(light->sphere, position));
}

double Lights::visible_share(std::size_t object, const glm::dvec3& position) const {
  const SphereLight* light = find(object);
  return light == nullptr ? 1.0 : std::min(1.0, cap_height(light->sphere, position));
}

}  // namespace alidade::renderer
