/* SPDX-License-Identifier: MIT */
\echo Use "CREATE EXTENSION alidade_pg" to load this file. \quit

-- A distance: a double of its own type, so that comparisons with it can be distinguished from all others. The planner
-- turns them into conditions on cloud_point(x,y,z), which indexes support.
CREATE TYPE cloud_distance;
CREATE FUNCTION cloud_distance_in(cstring) RETURNS cloud_distance
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE AS 'float8in';
CREATE FUNCTION cloud_distance_out(cloud_distance) RETURNS cstring
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE AS 'float8out';
CREATE FUNCTION cloud_distance_receive(internal) RETURNS cloud_distance
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE AS 'float8recv';
CREATE FUNCTION cloud_distance_send(cloud_distance) RETURNS bytea
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE AS 'float8send';
CREATE TYPE cloud_distance (INPUT = cloud_distance_in, OUTPUT = cloud_distance_out, RECEIVE = cloud_distance_receive,
  SEND = cloud_distance_send, LIKE = float8);
CREATE CAST (cloud_distance AS float8) WITHOUT FUNCTION AS IMPLICIT;
CREATE CAST (float8 AS cloud_distance) WITHOUT FUNCTION AS ASSIGNMENT;

-- So that EXECUTE takes any number for a parameter that is compared with a distance.
CREATE FUNCTION cloud_distance(real) RETURNS cloud_distance
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE AS 'ftod';
CREATE CAST (real AS cloud_distance) WITH FUNCTION cloud_distance(real) AS ASSIGNMENT;
CREATE FUNCTION cloud_distance(integer) RETURNS cloud_distance
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE AS 'i4tod';
CREATE CAST (integer AS cloud_distance) WITH FUNCTION cloud_distance(integer) AS ASSIGNMENT;
CREATE FUNCTION cloud_distance(bigint) RETURNS cloud_distance
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE AS 'i8tod';
CREATE CAST (bigint AS cloud_distance) WITH FUNCTION cloud_distance(bigint) AS ASSIGNMENT;
CREATE FUNCTION cloud_distance(numeric) RETURNS cloud_distance
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE AS 'numeric_float8';
CREATE CAST (numeric AS cloud_distance) WITH FUNCTION cloud_distance(numeric) AS ASSIGNMENT;
-- Where a double is taken, a distance is.
CREATE FUNCTION cloud_distance_to_real(cloud_distance) RETURNS real
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE AS 'dtof';
CREATE CAST (cloud_distance AS real) WITH FUNCTION cloud_distance_to_real(cloud_distance) AS ASSIGNMENT;
CREATE FUNCTION cloud_distance_to_smallint(cloud_distance) RETURNS smallint
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE AS 'dtoi2';
CREATE CAST (cloud_distance AS smallint) WITH FUNCTION cloud_distance_to_smallint(cloud_distance) AS ASSIGNMENT;
CREATE FUNCTION cloud_distance_to_integer(cloud_distance) RETURNS integer
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE AS 'dtoi4';
CREATE CAST (cloud_distance AS integer) WITH FUNCTION cloud_distance_to_integer(cloud_distance) AS ASSIGNMENT;
CREATE FUNCTION cloud_distance_to_bigint(cloud_distance) RETURNS bigint
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE AS 'dtoi8';
CREATE CAST (cloud_distance AS bigint) WITH FUNCTION cloud_distance_to_bigint(cloud_distance) AS ASSIGNMENT;
CREATE FUNCTION cloud_distance_to_numeric(cloud_distance) RETURNS numeric
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE AS 'float8_numeric';
CREATE CAST (cloud_distance AS numeric) WITH FUNCTION cloud_distance_to_numeric(cloud_distance) AS ASSIGNMENT;

-- A place: (x,y,z). Its order is the Morton order of cells of 2^-20 units.
CREATE TYPE cloud_point;
CREATE FUNCTION cloud_point_in(cstring) RETURNS cloud_point
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_point_in';
CREATE FUNCTION cloud_point_out(cloud_point) RETURNS cstring
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_point_out';
CREATE FUNCTION cloud_point_receive(internal) RETURNS cloud_point
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_point_receive';
CREATE FUNCTION cloud_point_send(cloud_point) RETURNS bytea
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_point_send';
CREATE TYPE cloud_point (INPUT = cloud_point_in, OUTPUT = cloud_point_out, RECEIVE = cloud_point_receive, SEND = cloud_point_send,
  INTERNALLENGTH = 24, ALIGNMENT = double);
CREATE FUNCTION cloud_point(x float8, y float8, z float8) RETURNS cloud_point
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_point';

-- What dist_ray measures from: the line through o along d, (ox,oy,oz,dx,dy,dz).
CREATE TYPE cloud_ray;
CREATE FUNCTION cloud_ray_in(cstring) RETURNS cloud_ray
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_ray_in';
CREATE FUNCTION cloud_ray_out(cloud_ray) RETURNS cstring
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_line_out';
CREATE FUNCTION cloud_ray_receive(internal) RETURNS cloud_ray
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_ray_receive';
CREATE FUNCTION cloud_ray_send(cloud_ray) RETURNS bytea
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_line_send';
CREATE TYPE cloud_ray (INPUT = cloud_ray_in, OUTPUT = cloud_ray_out, RECEIVE = cloud_ray_receive, SEND = cloud_ray_send,
  INTERNALLENGTH = 72, ALIGNMENT = double);
CREATE FUNCTION cloud_ray(ox float8, oy float8, oz float8, dx float8, dy float8, dz float8) RETURNS cloud_ray
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_ray';

-- What dist_plane measures from: the plane through p across n, (px,py,pz,nx,ny,nz).
CREATE TYPE cloud_plane;
CREATE FUNCTION cloud_plane_in(cstring) RETURNS cloud_plane
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_plane_in';
CREATE FUNCTION cloud_plane_out(cloud_plane) RETURNS cstring
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_line_out';
CREATE FUNCTION cloud_plane_receive(internal) RETURNS cloud_plane
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_plane_receive';
CREATE FUNCTION cloud_plane_send(cloud_plane) RETURNS bytea
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_line_send';
CREATE TYPE cloud_plane (INPUT = cloud_plane_in, OUTPUT = cloud_plane_out, RECEIVE = cloud_plane_receive, SEND = cloud_plane_send,
  INTERNALLENGTH = 72, ALIGNMENT = double);
CREATE FUNCTION cloud_plane(px float8, py float8, pz float8, nx float8, ny float8, nz float8) RETURNS cloud_plane
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_plane';

-- A limit on a distance, inclusive: ray(ox,oy,oz,dx,dy,dz,least,largest) or plane(px,py,pz,nx,ny,nz,least,largest).
CREATE TYPE cloud_limit;
CREATE FUNCTION cloud_limit_in(cstring) RETURNS cloud_limit
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_limit_in';
CREATE FUNCTION cloud_limit_out(cloud_limit) RETURNS cstring
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_limit_out';
CREATE FUNCTION cloud_limit_receive(internal) RETURNS cloud_limit
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_limit_receive';
CREATE FUNCTION cloud_limit_send(cloud_limit) RETURNS bytea
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_limit_send';
CREATE TYPE cloud_limit (INPUT = cloud_limit_in, OUTPUT = cloud_limit_out, RECEIVE = cloud_limit_receive, SEND = cloud_limit_send,
  INTERNALLENGTH = 96, ALIGNMENT = double);
CREATE FUNCTION ray_limit(ox float8, oy float8, oz float8, dx float8, dy float8, dz float8, low float8, high float8) RETURNS cloud_limit
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_ray_limit';
CREATE FUNCTION plane_limit(px float8, py float8, pz float8, nx float8, ny float8, nz float8, low float8, high float8) RETURNS cloud_limit
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_plane_limit';
-- The limit that points keep whose distance compares so with a value: cloud_limit(cloud_ray(...), '<=', 1).
CREATE FUNCTION cloud_limit(cloud_ray, comparison text, value float8) RETURNS cloud_limit
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_limit_by_ray';
CREATE FUNCTION cloud_limit(cloud_plane, comparison text, value float8) RETURNS cloud_limit
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_limit_by_plane';

-- What GiST indexes store: least corner and largest, (x,y,z,x,y,z).
CREATE TYPE cloud_box;
CREATE FUNCTION cloud_box_in(cstring) RETURNS cloud_box
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_box_in';
CREATE FUNCTION cloud_box_out(cloud_box) RETURNS cstring
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_box_out';
CREATE TYPE cloud_box (INPUT = cloud_box_in, OUTPUT = cloud_box_out, INTERNALLENGTH = 48, ALIGNMENT = double);

-- The distances of the paper (equations 5 and 6).
CREATE FUNCTION dist_ray_support(internal) RETURNS internal
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_dist_ray_support';
CREATE FUNCTION dist_ray(ox float8, oy float8, oz float8, dx float8, dy float8, dz float8, x float8, y float8, z float8) RETURNS cloud_distance
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE COST 3
  SUPPORT dist_ray_support AS 'MODULE_PATHNAME', 'alidade_dist_ray';
CREATE FUNCTION cloud_point_to_ray(cloud_point, cloud_ray) RETURNS float8
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE COST 3 AS 'MODULE_PATHNAME', 'alidade_distance_to_ray';
CREATE OPERATOR <-> (LEFTARG = cloud_point, RIGHTARG = cloud_ray, FUNCTION = cloud_point_to_ray);
CREATE FUNCTION dist_plane_support(internal) RETURNS internal
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_dist_plane_support';
CREATE FUNCTION dist_plane(px float8, py float8, pz float8, nx float8, ny float8, nz float8, x float8, y float8, z float8) RETURNS cloud_distance
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE COST 3
  SUPPORT dist_plane_support AS 'MODULE_PATHNAME', 'alidade_dist_plane';
CREATE FUNCTION cloud_point_to_plane(cloud_point, cloud_plane) RETURNS float8
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE COST 3 AS 'MODULE_PATHNAME', 'alidade_distance_to_plane';
CREATE OPERATOR <-> (LEFTARG = cloud_point, RIGHTARG = cloud_plane, FUNCTION = cloud_point_to_plane);

-- Whether a point keeps a limit: what comparisons of distances become.
CREATE FUNCTION cloud_keeping_share(internal, oid, internal, integer) RETURNS float8
  LANGUAGE C STABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_keeping_share';
CREATE FUNCTION cloud_breaking_share(internal, oid, internal, integer) RETURNS float8
  LANGUAGE C STABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_breaking_share';
CREATE FUNCTION cloud_point_keeps(cloud_point, cloud_limit) RETURNS boolean
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE COST 3 AS 'MODULE_PATHNAME', 'alidade_keeps_limit';
CREATE FUNCTION cloud_point_breaks(cloud_point, cloud_limit) RETURNS boolean
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE COST 3 AS 'MODULE_PATHNAME', 'alidade_breaks_limit';
CREATE OPERATOR <@ (LEFTARG = cloud_point, RIGHTARG = cloud_limit, FUNCTION = cloud_point_keeps,
  NEGATOR = !<@, RESTRICT = cloud_keeping_share, JOIN = contjoinsel);
CREATE OPERATOR !<@ (LEFTARG = cloud_point, RIGHTARG = cloud_limit, FUNCTION = cloud_point_breaks,
  NEGATOR = <@, RESTRICT = cloud_breaking_share, JOIN = neqjoinsel);

-- Comparisons with distances.
CREATE FUNCTION cloud_distance_support(internal) RETURNS internal
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_comparison_support';
CREATE FUNCTION cloud_distance_lt(cloud_distance, float8) RETURNS boolean
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE SUPPORT cloud_distance_support AS 'float8lt';
CREATE FUNCTION cloud_distance_lt(float8, cloud_distance) RETURNS boolean
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE SUPPORT cloud_distance_support AS 'float8lt';
CREATE FUNCTION cloud_distance_lt(cloud_distance, cloud_distance) RETURNS boolean
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE SUPPORT cloud_distance_support AS 'float8lt';
CREATE FUNCTION cloud_distance_le(cloud_distance, float8) RETURNS boolean
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE SUPPORT cloud_distance_support AS 'float8le';
CREATE FUNCTION cloud_distance_le(float8, cloud_distance) RETURNS boolean
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE SUPPORT cloud_distance_support AS 'float8le';
CREATE FUNCTION cloud_distance_le(cloud_distance, cloud_distance) RETURNS boolean
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE SUPPORT cloud_distance_support AS 'float8le';
CREATE FUNCTION cloud_distance_eq(cloud_distance, float8) RETURNS boolean
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE SUPPORT cloud_distance_support AS 'float8eq';
CREATE FUNCTION cloud_distance_eq(float8, cloud_distance) RETURNS boolean
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE SUPPORT cloud_distance_support AS 'float8eq';
CREATE FUNCTION cloud_distance_eq(cloud_distance, cloud_distance) RETURNS boolean
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE SUPPORT cloud_distance_support AS 'float8eq';
CREATE FUNCTION cloud_distance_ge(cloud_distance, float8) RETURNS boolean
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE SUPPORT cloud_distance_support AS 'float8ge';
CREATE FUNCTION cloud_distance_ge(float8, cloud_distance) RETURNS boolean
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE SUPPORT cloud_distance_support AS 'float8ge';
CREATE FUNCTION cloud_distance_ge(cloud_distance, cloud_distance) RETURNS boolean
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE SUPPORT cloud_distance_support AS 'float8ge';
CREATE FUNCTION cloud_distance_gt(cloud_distance, float8) RETURNS boolean
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE SUPPORT cloud_distance_support AS 'float8gt';
CREATE FUNCTION cloud_distance_gt(float8, cloud_distance) RETURNS boolean
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE SUPPORT cloud_distance_support AS 'float8gt';
CREATE FUNCTION cloud_distance_gt(cloud_distance, cloud_distance) RETURNS boolean
  LANGUAGE internal IMMUTABLE STRICT PARALLEL SAFE SUPPORT cloud_distance_support AS 'float8gt';
CREATE OPERATOR < (LEFTARG = cloud_distance, RIGHTARG = float8, FUNCTION = cloud_distance_lt,
  COMMUTATOR = >, NEGATOR = >=, RESTRICT = scalarltsel, JOIN = scalarltjoinsel);
CREATE OPERATOR < (LEFTARG = float8, RIGHTARG = cloud_distance, FUNCTION = cloud_distance_lt,
  COMMUTATOR = >, NEGATOR = >=, RESTRICT = scalarltsel, JOIN = scalarltjoinsel);
CREATE OPERATOR < (LEFTARG = cloud_distance, RIGHTARG = cloud_distance, FUNCTION = cloud_distance_lt,
  COMMUTATOR = >, NEGATOR = >=, RESTRICT = scalarltsel, JOIN = scalarltjoinsel);
CREATE OPERATOR <= (LEFTARG = cloud_distance, RIGHTARG = float8, FUNCTION = cloud_distance_le,
  COMMUTATOR = >=, NEGATOR = >, RESTRICT = scalarlesel, JOIN = scalarlejoinsel);
CREATE OPERATOR <= (LEFTARG = float8, RIGHTARG = cloud_distance, FUNCTION = cloud_distance_le,
  COMMUTATOR = >=, NEGATOR = >, RESTRICT = scalarlesel, JOIN = scalarlejoinsel);
CREATE OPERATOR <= (LEFTARG = cloud_distance, RIGHTARG = cloud_distance, FUNCTION = cloud_distance_le,
  COMMUTATOR = >=, NEGATOR = >, RESTRICT = scalarlesel, JOIN = scalarlejoinsel);
CREATE OPERATOR = (LEFTARG = cloud_distance, RIGHTARG = float8, FUNCTION = cloud_distance_eq,
  COMMUTATOR = =, RESTRICT = eqsel, JOIN = eqjoinsel);
CREATE OPERATOR = (LEFTARG = float8, RIGHTARG = cloud_distance, FUNCTION = cloud_distance_eq,
  COMMUTATOR = =, RESTRICT = eqsel, JOIN = eqjoinsel);
CREATE OPERATOR = (LEFTARG = cloud_distance, RIGHTARG = cloud_distance, FUNCTION = cloud_distance_eq,
  COMMUTATOR = =, RESTRICT = eqsel, JOIN = eqjoinsel);
CREATE OPERATOR >= (LEFTARG = cloud_distance, RIGHTARG = float8, FUNCTION = cloud_distance_ge,
  COMMUTATOR = <=, NEGATOR = <, RESTRICT = scalargesel, JOIN = scalargejoinsel);
CREATE OPERATOR >= (LEFTARG = float8, RIGHTARG = cloud_distance, FUNCTION = cloud_distance_ge,
  COMMUTATOR = <=, NEGATOR = <, RESTRICT = scalargesel, JOIN = scalargejoinsel);
CREATE OPERATOR >= (LEFTARG = cloud_distance, RIGHTARG = cloud_distance, FUNCTION = cloud_distance_ge,
  COMMUTATOR = <=, NEGATOR = <, RESTRICT = scalargesel, JOIN = scalargejoinsel);
CREATE OPERATOR > (LEFTARG = cloud_distance, RIGHTARG = float8, FUNCTION = cloud_distance_gt,
  COMMUTATOR = <, NEGATOR = <=, RESTRICT = scalargtsel, JOIN = scalargtjoinsel);
CREATE OPERATOR > (LEFTARG = float8, RIGHTARG = cloud_distance, FUNCTION = cloud_distance_gt,
  COMMUTATOR = <, NEGATOR = <=, RESTRICT = scalargtsel, JOIN = scalargtjoinsel);
CREATE OPERATOR > (LEFTARG = cloud_distance, RIGHTARG = cloud_distance, FUNCTION = cloud_distance_gt,
  COMMUTATOR = <, NEGATOR = <=, RESTRICT = scalargtsel, JOIN = scalargtjoinsel);

-- btree: Morton order. BRIN needs it to learn from ANALYZE how well a table is ordered.
CREATE FUNCTION cloud_point_order(cloud_point, cloud_point) RETURNS integer
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_point_order';
CREATE FUNCTION cloud_point_sort_support(internal) RETURNS void
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_point_sort_support';
CREATE FUNCTION cloud_point_before(cloud_point, cloud_point) RETURNS boolean
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_point_before';
CREATE FUNCTION cloud_point_not_after(cloud_point, cloud_point) RETURNS boolean
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_point_not_after';
CREATE FUNCTION cloud_point_equal(cloud_point, cloud_point) RETURNS boolean
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_point_equal';
CREATE FUNCTION cloud_point_not_before(cloud_point, cloud_point) RETURNS boolean
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_point_not_before';
CREATE FUNCTION cloud_point_after(cloud_point, cloud_point) RETURNS boolean
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_point_after';
CREATE OPERATOR < (LEFTARG = cloud_point, RIGHTARG = cloud_point, FUNCTION = cloud_point_before,
  COMMUTATOR = >, NEGATOR = >=, RESTRICT = scalarltsel, JOIN = scalarltjoinsel);
CREATE OPERATOR <= (LEFTARG = cloud_point, RIGHTARG = cloud_point, FUNCTION = cloud_point_not_after,
  COMMUTATOR = >=, NEGATOR = >, RESTRICT = scalarlesel, JOIN = scalarlejoinsel);
CREATE OPERATOR = (LEFTARG = cloud_point, RIGHTARG = cloud_point, FUNCTION = cloud_point_equal,
  COMMUTATOR = =, RESTRICT = eqsel, JOIN = eqjoinsel);
CREATE OPERATOR >= (LEFTARG = cloud_point, RIGHTARG = cloud_point, FUNCTION = cloud_point_not_before,
  COMMUTATOR = <=, NEGATOR = <, RESTRICT = scalargesel, JOIN = scalargejoinsel);
CREATE OPERATOR > (LEFTARG = cloud_point, RIGHTARG = cloud_point, FUNCTION = cloud_point_after,
  COMMUTATOR = <, NEGATOR = <=, RESTRICT = scalargtsel, JOIN = scalargtjoinsel);
CREATE OPERATOR CLASS cloud_point_morton_ops DEFAULT FOR TYPE cloud_point USING btree AS
  OPERATOR 1 <, OPERATOR 2 <=, OPERATOR 3 =, OPERATOR 4 >=, OPERATOR 5 >,
  FUNCTION 1 cloud_point_order(cloud_point, cloud_point),
  FUNCTION 2 cloud_point_sort_support(internal);

-- BRIN: a box for each range of pages.
CREATE FUNCTION cloud_brin_columns(internal) RETURNS internal
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_brin_columns';
CREATE FUNCTION cloud_brin_add(internal, internal, internal, internal) RETURNS boolean
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_brin_add';
CREATE FUNCTION cloud_brin_consistent(internal, internal, internal, integer) RETURNS boolean
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_brin_consistent';
CREATE FUNCTION cloud_brin_union(internal, internal, internal) RETURNS boolean
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_brin_union';
CREATE OPERATOR CLASS cloud_point_box_ops DEFAULT FOR TYPE cloud_point USING brin AS
  OPERATOR 1 <@ (cloud_point, cloud_limit),
  OPERATOR 2 !<@ (cloud_point, cloud_limit),
  FUNCTION 1 cloud_brin_columns(internal),
  FUNCTION 2 cloud_brin_add(internal, internal, internal, internal),
  FUNCTION 3 cloud_brin_consistent(internal, internal, internal, integer),
  FUNCTION 4 cloud_brin_union(internal, internal, internal);

-- GiST: a tree of boxes, which also finds the nearest points.
CREATE FUNCTION cloud_gist_compress(internal) RETURNS internal
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_gist_compress';
CREATE FUNCTION cloud_gist_consistent(internal, cloud_point, smallint, oid, internal) RETURNS boolean
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_gist_consistent';
CREATE FUNCTION cloud_gist_distance(internal, cloud_point, smallint, oid, internal) RETURNS float8
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_gist_distance';
CREATE FUNCTION cloud_gist_union(internal, internal) RETURNS cloud_box
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_gist_union';
CREATE FUNCTION cloud_gist_penalty(internal, internal, internal) RETURNS internal
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_gist_penalty';
CREATE FUNCTION cloud_gist_split(internal, internal) RETURNS internal
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_gist_split';
CREATE FUNCTION cloud_gist_same(cloud_box, cloud_box, internal) RETURNS internal
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_gist_same';
CREATE FUNCTION cloud_gist_sort_support(internal) RETURNS void
  LANGUAGE C IMMUTABLE STRICT PARALLEL SAFE AS 'MODULE_PATHNAME', 'alidade_gist_sort_support';
CREATE OPERATOR CLASS cloud_point_tree_ops DEFAULT FOR TYPE cloud_point USING gist AS
  OPERATOR 1 <@ (cloud_point, cloud_limit),
  OPERATOR 2 !<@ (cloud_point, cloud_limit),
  OPERATOR 15 <-> (cloud_point, cloud_ray) FOR ORDER BY float_ops,
  OPERATOR 16 <-> (cloud_point, cloud_plane) FOR ORDER BY float_ops,
  FUNCTION 1 cloud_gist_consistent(internal, cloud_point, smallint, oid, internal),
  FUNCTION 2 cloud_gist_union(internal, internal),
  FUNCTION 3 cloud_gist_compress(internal),
  FUNCTION 5 cloud_gist_penalty(internal, internal, internal),
  FUNCTION 6 cloud_gist_split(internal, internal),
  FUNCTION 7 cloud_gist_same(cloud_box, cloud_box, internal),
  FUNCTION 8 cloud_gist_distance(internal, cloud_point, smallint, oid, internal),
  FUNCTION 11 cloud_gist_sort_support(internal),
  STORAGE cloud_box;

COMMENT ON FUNCTION dist_ray(float8, float8, float8, float8, float8, float8, float8, float8, float8) IS
  'distance of (x,y,z) to the line through (ox,oy,oz) along (dx,dy,dz)';
COMMENT ON FUNCTION dist_plane(float8, float8, float8, float8, float8, float8, float8, float8, float8) IS
  'signed distance of (x,y,z) to the plane through (px,py,pz) across (nx,ny,nz)';
COMMENT ON FUNCTION cloud_point(float8, float8, float8) IS 'a place: what indexes are made on, and the order to store points in';
COMMENT ON FUNCTION ray_limit(float8, float8, float8, float8, float8, float8, float8, float8) IS
  'what points keep whose dist_ray is between low and high, inclusive';
COMMENT ON FUNCTION plane_limit(float8, float8, float8, float8, float8, float8, float8, float8) IS
  'what points keep whose dist_plane is between low and high, inclusive';
COMMENT ON FUNCTION cloud_limit(cloud_ray, text, float8) IS 'what points keep whose distance to the ray compares so with the value';
COMMENT ON FUNCTION cloud_limit(cloud_plane, text, float8) IS 'what points keep whose distance to the plane compares so with the value';
COMMENT ON OPERATOR <@ (cloud_point, cloud_limit) IS 'keeps the limit';
COMMENT ON OPERATOR !<@ (cloud_point, cloud_limit) IS 'breaks the limit';
COMMENT ON OPERATOR <-> (cloud_point, cloud_ray) IS 'dist_ray';
COMMENT ON OPERATOR <-> (cloud_point, cloud_plane) IS 'dist_plane';
