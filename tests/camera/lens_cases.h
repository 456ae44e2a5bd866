// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "renderer/scene.h"

namespace alidade::test {

using namespace camera;

/// A camera with the name of what is special about it.
struct LensCase {
  std::string name;
  Camera camera;
};

/// Cameras with every lens, as strong as real ones are, all invertible over their image: 640 x 480, focal
/// length about half the width, principal point off the middle, turned and shifted.
inline std::vector<LensCase> lens_cases() {
  Camera camera{
      .width = 640, .height = 480, .fx = 520.25, .fy = 518.5, .cx = 331.5, .cy = 229.25, .pose = {}};
  camera.pose = {.position = {1.0, -2.0, 0.5},
                 .right = {0.6, 0.8, 0.0},
                 .down = {0.0, 0.0, -1.0},
                 .forward = {-0.8, 0.6, 0.0}};
  std::vector<LensCase> cases;
  const auto add = [&](const char* name, const Lens& lens, double focal_length) {
    Camera each = camera;
    each.lens = lens;
    each.fx *= focal_length / 520.25;
    each.fy *= focal_length / 520.25;
    cases.push_back({name, each});
  };
  const auto brown = [](std::array<double, 6> radial, std::array<double, 3> denominator, double p1,
                        double p2) {
    return BrownLens{{.radial = radial, .denominator = denominator, .p1 = p1, .p2 = p2}};
  };
  add("pinhole", PinholeLens{}, 520.25);
  add("one coefficient, barrel", brown({-0.12}, {}, 0, 0), 520.25);
  add("one coefficient, pincushion", brown({0.2}, {}, 0, 0), 520.25);
  add("two coefficients", brown({-0.28, 0.09}, {}, 0, 0), 520.25);
  add("brown", brown({-0.28, 0.09, -0.01}, {}, 0.0012, -0.0021), 520.25);
  add("tangential alone", brown({}, {}, 0.01, -0.02), 520.25);
  add("rational", brown({8.1, 3.2, 0.15}, {8.4, 5.9, 1.1}, 0.0003, -0.0002), 520.25);
  add("radial to the eighth power", brown({-0.2, 0.05, -0.01, 0.002}, {}, 0, 0), 520.25);
  BrownLens prism = brown({-0.1, 0.02}, {}, 0.001, 0.002);
  prism.distortion.prism = {0.003, -0.001, -0.002, 0.0005};
  add("brown with thin prism", prism, 520.25);
  add("ideal fisheye", FisheyeLens{}, 140.0);
  add("fisheye", FisheyeLens{{.radial = {-0.02, 0.004, -0.0006, 0.00003}}}, 200.0);
  add("fisheye with thin prism",
      FisheyeLens{{.radial = {-0.02, 0.004}, .p1 = 0.002, .p2 = -0.001, .prism = {0.001, 0.0, -0.002, 0.0}}},
      220.0);
  add("fisheye 624",
      FisheyeLens{{.radial = {0.03, -0.02, 0.01, -0.004, 0.0008, -0.00006},
                   .p1 = 0.002,
                   .p2 = -0.001,
                   .prism = {0.001, -0.0002, -0.002, 0.0001},
                   .after_radial = true}},
      260.0);
  add("vertical field of view out of range", FieldOfViewLens{0.93}, 400.0);
  add("field of view, none", FieldOfViewLens{0.0}, 520.25);
  add("field of view, hardly any", FieldOfViewLens{1e-6}, 520.25);
  add("division, barrel", DivisionLens{-0.3}, 300.0);
  add("division, beyond 90 degrees", DivisionLens{-0.9}, 250.0);
  add("division, pincushion", DivisionLens{0.1}, 520.25);
  add("unified", UnifiedLens{0.6, 1.1}, 300.0);
  add("unified, half", UnifiedLens{0.5, 0.9}, 250.0);
  add("dual", DualLens{0.4, {.radial = {-0.03, 0.004}}}, 300.0);
  add("orthographic", OrthographicLens{}, 33.0);
  Camera sphere = camera;
  sphere.lens = EquirectangularLens{};
  sphere.fx = 640.0 / 6.283185307179586;
  sphere.fy = 480.0 / 3.141592653589793;
  sphere.cx = 320.0;
  sphere.cy = 240.0;
  cases.push_back({"equirectangular", sphere});
  return cases;
}

}  // namespace alidade::test
