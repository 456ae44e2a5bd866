// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "octree/cloud/crs.h"

namespace alidade {

/// EPSG codes that GeoTIFF keys give directly, as "EPSG:25832" and "vertical EPSG:7837": geographic,
/// projected and vertical system.
std::vector<std::string> epsg_codes(const Crs& crs);

/// Name of a system for people: that in its WKT, else its EPSG codes.
std::string crs_name(const Crs& crs);

/// What is known about two systems being one.
enum class CrsAgreement { same, unknown, different };

/// Compares two systems that are not empty: by their EPSG codes where both have one, else WKT by its names,
/// letters and digits alone, and GeoTIFF keys among themselves as they are. WKT without code beside keys
/// cannot be compared.
CrsAgreement compare_crs(const Crs& a, const Crs& b);

}  // namespace alidade
