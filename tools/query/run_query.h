// SPDX-License-Identifier: MIT
#pragma once

#include "tools/exit_code.h"
#include "tools/query/query.h"

namespace alidade {

/// Does what was asked: reads targets, asks the octree batch by batch in parallel, writes. Memory beside
/// cloud and octree: about 200 MB at most, whatever the number of targets and answers; a single target with
/// more than a million answers takes what these take; if work is explained, some dozens of them. Errors: of
/// options that do not go together, of cloud, targets and output.
template <class Target>
ExitCode run_query(const QueryCommand& command, TargetFamily family);

extern template ExitCode run_query<Ray>(const QueryCommand& command, TargetFamily family);
extern template ExitCode run_query<Cone>(const QueryCommand& command, TargetFamily family);
extern template ExitCode run_query<Path>(const QueryCommand& command, TargetFamily family);
extern template ExitCode run_query<HalfSpaces>(const QueryCommand& command, TargetFamily family);
extern template ExitCode run_query<Bounds>(const QueryCommand& command, TargetFamily family);
extern template ExitCode run_query<glm::dvec3>(const QueryCommand& command, TargetFamily family);

}  // namespace alidade
