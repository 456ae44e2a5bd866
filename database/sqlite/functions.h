// SPDX-License-Identifier: MIT
#pragma once

#include "database/sqlite/sqlite_api.h"

namespace alidade {

/// Gives a connection the functions
///   dist_ray(ox,oy,oz, dx,dy,dz, x,y,z)    distance of a point to the line through o along d (eq. 1)
///   dist_plane(px,py,pz, nx,ny,nz, x,y,z)  signed distance to the plane through p across n (eq. 2)
///   ray_limit(ox,..,dz, least, largest), plane_limit(px,..,nz, least, largest), in_chunk(_chunk, limit):
///     in_chunk is 1 for every point; as a condition on a table of the module it may leave out points whose
///     distance is not within the limit, and leaves chunks unread that have no other. Which of them it leaves
///     out depends on the plan: it must stand beside the condition on the distance that it is made of.
/// Lengths in the unit of the coordinates; directions and normals of any length but zero. NULL for an
/// argument gives NULL. Errors, in SQL: text or blobs for numbers, directions that are zero or not finite,
/// places of the ray or plane that are not finite; the distance to a point that is not is NULL or infinite.
/// Answers SQLite's code.
int add_functions(sqlite3* database);

/// The function in_chunk as SQLite calls it.
void in_chunk(sqlite3_context* context, int count, sqlite3_value** values);

}  // namespace alidade
