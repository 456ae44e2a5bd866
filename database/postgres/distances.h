// SPDX-License-Identifier: MIT
#pragma once

#include "database/postgres/postgres_api.h"

// Functions of SQL that the planner's support recognises in expressions.
extern "C" {
Datum alidade_distance_to_ray(PG_FUNCTION_ARGS);
Datum alidade_distance_to_plane(PG_FUNCTION_ARGS);
Datum alidade_keeps_limit(PG_FUNCTION_ARGS);
Datum alidade_breaks_limit(PG_FUNCTION_ARGS);
Datum alidade_limit_by_plane(PG_FUNCTION_ARGS);
}
