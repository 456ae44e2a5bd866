// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cloud/crs.h"

namespace alidade {

/// EPSG codes that GeoTIFF keys give directly, as "EPSG:25832" and "vertical EPSG:7837": geographic,
/// projected and vertical system.
std::vector<std::string> epsg_codes(const Crs& crs);

/// Name of a system for people: that in its WKT, else its EPSG codes.
std::string crs_name(const Crs& crs);

/// Letters and digits of a name, in lower case: what names of one thing share between programs.
std::string letters_and_digits(std::string_view name);

/// What is known about two systems being one.
enum class CrsAgreement { same, unknown, different };

/// Compares two systems that are not empty: by their EPSG codes where both have one, else WKT by its names,
/// letters and digits alone, and GeoTIFF keys among themselves as they are. Nothing is known of WKT without
/// code beside keys, and of two names for the same numbers (same_definition()).
CrsAgreement compare_crs(const Crs& a, const Crs& b);

}  // namespace alidade
