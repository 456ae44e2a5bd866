// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>

#include "geo/raster.h"
#include "visibility/sight_line.h"

// Lines over the bilinear surface of an elevation raster, computed in another way than by the program: piece
// by piece between two edges of patches, where the surface along the line is a quadratic through three of its
// heights. Cells without height are holes. In double precision; for tests.

namespace alidade::test {

/// What a line has of the surface below and above it.
struct Clearance {
  double lowest = std::numeric_limits<double>::infinity();
  bool crosses = false;  ///< the surface, by more than a micrometre, which rounding takes at the ends
};

/// Of a line over the surface. Through a hole it comes below the surface without crossing it.
Clearance clearance_of(const geo::Raster<float>& heights, const glm::dvec3& eye, const glm::dvec3& target);

/// Elevation of the horizon of an eye in an azimuth (degrees clockwise from north), degrees above the
/// horizontal; -90 where there is no surface. Requires an eye on or above the surface.
double exact_horizon(const geo::Raster<float>& heights, const glm::dvec3& eye, double azimuth);

/// 1/pi times the integral of sin(elevation) over the sky above the exact horizon: the mean of cos^2 of the
/// horizon's elevation, or of 0 where it is lower, over so many even azimuths.
double exact_sky_view(const geo::Raster<float>& heights, const glm::dvec3& eye, int azimuths);

/// The elevations of r.viewshed's test data; empty where the shared data are absent.
std::optional<geo::Raster<float>> elevation_of_r_viewshed();

/// A raster that blocks, without points.
visibility::Occluders occluders_of(const geo::Raster<float>& heights);

/// So high above the bilinear surface at a position in cells from the centre of the north-western one.
glm::dvec3 above(const geo::Raster<float>& heights, const glm::dvec2& cell, double height);

}  // namespace alidade::test
