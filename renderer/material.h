// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <variant>

namespace alidade {

/// Colours in scene structs and in the tracer are linear Rec. 709, per channel; albedos lie in [0, 1].
using Rgb = glm::vec3;

/// Diffuse reflection, equal in all directions. Without an albedo the colour of the hit point is used.
struct Lambertian {
  std::optional<Rgb> albedo;
};

/// Mirror that blurs with roughness: 0 is a perfect mirror, 1 the roughest. Without an albedo the point's colour.
struct Metal {
  std::optional<Rgb> albedo;
  double roughness = 0.0;
};

/// Clear glass or water with an index of refraction relative to the air around it.
struct Dielectric {
  double refractive_index = 1.5;
};

/// Surface that shines by itself with this radiance and reflects nothing.
struct Emissive {
  Rgb radiance{1.0f};
};

/// What a surface does with light; the word in scene files ("type") is the struct's name in lower case.
using Material = std::variant<Lambertian, Metal, Dielectric, Emissive>;

}  // namespace alidade
