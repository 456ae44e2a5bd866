// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace alidade {

/// Whether two projected systems, WKT of version 1, are defined by the same numbers: ellipsoid, prime
/// meridian, units, and the parameters of the projection, which are told by the letters and digits of their
/// names. Programs give systems, datums and projections names of their own, as "ETRS89 / UTM zone 32N" and
/// "ETRS_1989_UTM_Zone_32N"; numbers they share up to their last digit. True does not say that the systems
/// are one: datums on one ellipsoid lie up to some metres apart. False for what has no parameters, or other
/// ones, as WKT of version 2 beside that of version 1.
bool same_definition(const std::string& wkt_a, const std::string& wkt_b);

}  // namespace alidade
