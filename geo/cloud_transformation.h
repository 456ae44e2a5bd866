// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <string>

#include "geo/gdal_reference.h"
#include "geo/observer_reference.h"

namespace alidade {

/// The way from a file's reference system, `own`, WKT, empty if the file says nothing, to the cloud's; null
/// if places stay what they are, because both are the same or none is known. `source` is what an Error names.
/// Errors: one is known and the other not; one that GDAL does not understand; there is no way.
GdalTransformation transformation_to_cloud(const std::string& own, const ObserverReference& reference,
                                           const std::string& source);

/// A place in the cloud's reference system. Errors: it has no image there; they name `source`.
glm::dvec2 transformed(const glm::dvec2& place, const GdalTransformation& transformation,
                       const std::string& source);

}  // namespace alidade
