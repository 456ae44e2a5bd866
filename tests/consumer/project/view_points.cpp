// SPDX-License-Identifier: MIT
#include <cstdio>

#include "camera/camera.h"
#include "renderer/render.h"

int main() {
  alidade::renderer::Scene scene;
  scene.objects.push_back(alidade::renderer::Sphere{});
  scene.camera = alidade::camera::overview_camera({.min = glm::dvec3(-1.0), .max = glm::dvec3(1.0)}, 16, 12);
  scene.render.samples = 2;
  const alidade::image::Film film = alidade::renderer::render(scene, nullptr);
  const float alpha = film.alpha[film.index(8, 6)];
  std::printf("the middle of the picture has alpha %g\n", static_cast<double>(alpha));
  return alpha == 1.0f ? 0 : 1;
}
