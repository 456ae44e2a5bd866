// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "base/progress.h"
#include "database/point_filter.h"
#include "tools/query/query.h"

namespace alidade {

/// What answers can come from of a cloud that lies in a database, from a first look through the targets;
/// empty if that is all of it, or cannot be known: without a radius, for targets that come through a pipe,
/// and for levels. Errors: those of targets, and of the database.
template <class Target>
std::optional<CloudPart> read_query_part(const QueryCommand& command, TargetFamily family,
                                         AttributeSet attributes, const Progress& progress);

extern template std::optional<CloudPart> read_query_part<Ray>(const QueryCommand&, TargetFamily, AttributeSet,
                                                              const Progress&);
extern template std::optional<CloudPart> read_query_part<Cone>(const QueryCommand&, TargetFamily,
                                                               AttributeSet, const Progress&);
extern template std::optional<CloudPart> read_query_part<Path>(const QueryCommand&, TargetFamily,
                                                               AttributeSet, const Progress&);
extern template std::optional<CloudPart> read_query_part<HalfSpaces>(const QueryCommand&, TargetFamily,
                                                                     AttributeSet, const Progress&);
extern template std::optional<CloudPart> read_query_part<Bounds>(const QueryCommand&, TargetFamily,
                                                                 AttributeSet, const Progress&);
extern template std::optional<CloudPart> read_query_part<glm::dvec3>(const QueryCommand&, TargetFamily,
                                                                     AttributeSet, const Progress&);

}  // namespace alidade
