// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <vector>

namespace alidade {

constexpr int k_most_sky_directions = 1 << 20;

/// Directions to the sky, spread evenly over the upper hemisphere, each for 1/count of its solid angle: the
/// i-th at sin(elevation) = (i + 1/2) / count, each turned by the golden angle from the one before. The same
/// bits on every machine. Source: Gonzalez, Measurement of Areas on a Sphere Using Fibonacci and
/// Latitude-Longitude Lattices, 2010. Requires 1 <= count <= k_most_sky_directions.
std::vector<glm::dvec3> even_sky_directions(int count);

/// The same with a density that goes with sin(elevation), so that each stands for 1/count of the light that
/// an even sky sends to a horizontal receiver: sin^2(elevation) = 1 - (i + 1/2) / count. Source: the
/// projection of the hemisphere onto its base, Nusselt 1928.
std::vector<glm::dvec3> cosine_sky_directions(int count);

}  // namespace alidade
