// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "simulation/shapes.h"

namespace alidade::simulation {

/// The material of a surface of a site. Defines the pattern of its colour, its class and its reflectance.
enum class SiteMaterial : std::uint8_t {
  terrain,  ///< the site's ground: a Pavement by its face
  plaster,  ///< house wall; `size.y` is the height of the darker plinth
  trim,     ///< stone frames, cornices and pillars of a house
  brick,
  stone,  ///< dressed stone in courses
  roof_tile,
  window,  ///< niche with reveal, frame and panes; `size` is the opening's
  door,    ///< niche with reveal and boards; `size` is the opening's
  wood,
  metal,
  bark,
  leaf,   ///< one leaf, its shade from `seed`
  hedge,  ///< clipped shrub
  water,
  car_body,
  car_cabin,  ///< glass all round below the roof
  tyre,
  lamp_glass,
  target,  ///< white reference sphere of surveyors
};

/// Faces of the terrain (shapes::Patch::face): the surface of the ground.
enum class Pavement : int { grass, cobble, slab, gravel, asphalt, road_marking, soil };

/// The appearance of one shape of a site.
struct Finish {
  SiteMaterial material = SiteMaterial::stone;
  glm::dvec3 tint{0.5};    ///< base colour, display-referred (sRGB), 0 .. 1
  glm::dvec2 size{0.0};    ///< see SiteMaterial
  std::uint32_t seed = 0;  ///< distinguishes similar shapes
};

/// Colour at one position, display-referred (sRGB), 0 .. 1. Made from hash noise with +, -, *, / and floor
/// only, so that it has the same bits on every machine.
glm::dvec3 color_of(const Finish& finish, const shapes::SurfacePoint& surface, const glm::dvec3& position);

/// ASPRS class: 1 unclassified, 2 ground, 3 low and 5 high vegetation, 6 building, 9 water, 11 road surface;
/// own: 64 car, 65 street furniture, 66 survey target.
std::uint8_t classification_of(const Finish& finish, const shapes::SurfacePoint& surface,
                               const glm::dvec3& position);

/// Share of a near-infrared laser's light that a surface reflects, 0 .. 1: from its colour,
/// higher for leaves and grass.
double reflectance_of(SiteMaterial material, const glm::dvec3& color);

}  // namespace alidade::simulation
