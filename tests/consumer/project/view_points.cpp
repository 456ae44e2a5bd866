// SPDX-License-Identifier: MIT
#include <cstdio>

#include "camera/camera.h"
#include "image/image_file.h"
#include "renderer/render.h"

int main(int count, char** words) {
  if (count != 2) return 1;
  alidade::renderer::Scene scene;
  scene.objects.push_back(alidade::renderer::Sphere{});
  scene.camera = alidade::camera::overview_camera({.min = glm::dvec3(-1.0), .max = glm::dvec3(1.0)}, 16, 12);
  scene.render.samples = 2;
  const alidade::image::Film film = alidade::renderer::render(scene, nullptr);
  const float alpha = film.alpha[film.index(8, 6)];
  std::printf("the middle of the picture has alpha %g\n", static_cast<double>(alpha));
  // The library finds the module that it was installed with.
  alidade::image::write_image(film, {.file = words[1]}, {}, true);
  return alpha == 1.0f ? 0 : 1;
}
