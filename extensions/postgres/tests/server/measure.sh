#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Measures alidade_pg on a server of its own: measure.sh EXTENSION_FOLDER PG_CONFIG [POINTS [POINTS_IN_TREE]]
# A site of 200 x 200 m, half undulating ground, half faces of 60 boxes, in Morton order; by default 1e7 points under BRIN and 1e6
# under GiST. Prints medians of nine runs, each beside what no index can answer, in the same run.
set -euo pipefail
extension=$(realpath -- "$1")
source "$(dirname -- "$0")/private_cluster.sh"
cluster_begin "$extension" "$2"
points=${3:-10000000}
points_in_tree=${4:-1000000}
cluster_start server shared_buffers=1GB work_mem=256MB maintenance_work_mem=512MB max_wal_size=16GB max_parallel_workers_per_gather=0
server=$(cluster_of server)
run() { psql -X -q -A -t -v ON_ERROR_STOP=1 "$server" "$@"; }

echo "load before: $(cut -d' ' -f1-3 /proc/loadavg), $(nproc) processors"
run <<'SQL'
CREATE EXTENSION alidade_pg;
CREATE FUNCTION site(count int) RETURNS TABLE (id int, x float8, y float8, z float8) LANGUAGE sql AS $$
  -- Half of the points on the ground; the others on a wall or the roof of a box, chosen by chance.
  WITH box AS MATERIALIZED (
    SELECT array_agg(10 + 180 * random()) x, array_agg(10 + 180 * random()) y, array_agg(3 + 5 * random()) half, array_agg(4 + 12 * random()) height
    FROM generate_series(1, 60))
  SELECT id, CASE WHEN face = 0 THEN u * 200 WHEN face IN (1, 2) THEN bx + half * (2 * u - 1) ELSE bx + half * (2 * (face - 3) - 1) END,
         CASE WHEN face = 0 THEN v * 200 WHEN face = 1 THEN by + half * (2 * v - 1) WHEN face = 2 THEN by - half ELSE by + half * (2 * u - 1) END,
         CASE WHEN face = 0 THEN 0.2 + sin(u * 10) + 0.5 * cos(v * 14) WHEN face = 1 THEN height ELSE v * height END
  FROM (SELECT id, u, v, face, box.x[n] AS bx, box.y[n] AS by, box.half[n] AS half, box.height[n] AS height FROM box,
        (SELECT id, random() AS u, random() AS v, 1 + floor(random() * 60)::int AS n,
                CASE WHEN random() < 0.5 THEN 0 ELSE 1 + floor(random() * 4)::int END AS face FROM generate_series(1, count) AS id) r) f
$$;
-- The median time of nine runs in ms, after one that warms the cache, and what the last one read and found.
CREATE FUNCTION measured(name text, statement text) RETURNS text LANGUAGE plpgsql AS $$
DECLARE plan json; times float8[]; pages float8;
BEGIN
  FOR i IN 0..9 LOOP
    EXECUTE 'EXPLAIN (ANALYZE, BUFFERS, TIMING OFF, FORMAT JSON) ' || statement INTO plan;
    IF i > 0 THEN times := times || ((plan->0->>'Execution Time')::float8 + (plan->0->>'Planning Time')::float8); END IF;
  END LOOP;
  pages := (plan->0->'Plan'->>'Shared Hit Blocks')::float8 + (plan->0->'Plan'->>'Shared Read Blocks')::float8;
  RETURN format('%s %s ms (%s to %s), %s rows, %s pages read, expected %s rows', rpad(name, 44),
    (SELECT round(percentile_cont(0.5) WITHIN GROUP (ORDER BY t)::numeric, 2) FROM unnest(times) t),
    (SELECT round(min(t)::numeric, 2) FROM unnest(times) t), (SELECT round(max(t)::numeric, 2) FROM unnest(times) t),
    plan->0->'Plan'->>'Actual Rows', pages, plan->0->'Plan'->>'Plan Rows');
END $$;
SQL

# fill TABLE COUNT
fill() {
  run -c "DO \$\$ BEGIN PERFORM setseed(0.25); END \$\$" -c "CREATE UNLOGGED TABLE staging AS SELECT * FROM site($2)"
  local begin=$EPOCHREALTIME
  run -c "CREATE TABLE $1(id int, x float8 NOT NULL, y float8 NOT NULL, z float8 NOT NULL)" \
    -c "INSERT INTO $1 SELECT * FROM staging ORDER BY cloud_point(x,y,z)" -c "DROP TABLE staging"
  echo "$1: $2 points stored in Morton order in $(bc <<<"$EPOCHREALTIME - $begin") s, $(run -c "SELECT pg_relation_size('$1') / 8192") pages"
}

# index TABLE METHOD OPTIONS
index() {
  local begin=$EPOCHREALTIME
  run -c "CREATE INDEX $1_$2 ON $1 USING $2 (cloud_point(x,y,z)) $3"
  echo "$1: $2 $3 made in $(bc <<<"$EPOCHREALTIME - $begin") s, $(run -c "SELECT pg_size_pretty(pg_relation_size('$1_$2'))")"
  run -c "VACUUM ANALYZE $1"
}

ray="0,100,1.5, 1,0.2,0, x,y,z"
fill points "$points"
index points brin "WITH (pages_per_range = 8)"
for radius in 1 0.1; do
  run -c "SELECT measured('BRIN, ray of $radius m', 'SELECT * FROM points WHERE dist_ray($ray) <= $radius')"
done
run -c "SELECT measured('the same without index, 1 m', 'SELECT * FROM points WHERE dist_ray($ray)::float8 <= 1')"
run -c "SELECT measured('BRIN, ray of 1 m in a slab of 10 m', 'SELECT * FROM points WHERE dist_ray($ray) <= 1 AND dist_plane($ray) BETWEEN 50 AND 60')"
run -c "DROP INDEX points_brin"
index points brin "WITH (pages_per_range = 2)"
run -c "SELECT measured('BRIN, 2 pages a range, ray of 1 m', 'SELECT * FROM points WHERE dist_ray($ray) <= 1')"
run -c "DROP TABLE points"

fill tree "$points_in_tree"
index tree gist ""
run -c "CREATE TABLE rays AS SELECT 200 * share AS oy, share - 0.5 AS dy FROM (SELECT i / 44.0 AS share FROM generate_series(1, 44) i) s" -c "ANALYZE rays"
run -c "SELECT measured('GiST, 44 rays of 0.5 m joined', 'SELECT * FROM rays, tree WHERE dist_ray(0,oy,1.5, 1,dy,0, x,y,z) <= 0.5')"
run -c "SELECT measured('GiST, nearest 10', 'SELECT * FROM tree ORDER BY dist_ray($ray) LIMIT 10')"
run -c "SELECT measured('GiST, first hit within 0.1 m', 'SELECT * FROM tree WHERE dist_ray($ray) <= 0.1 AND dist_plane($ray) >= 0 ORDER BY dist_plane($ray) LIMIT 1')"
run -c "SELECT measured('GiST, ray of 1 m', 'SELECT * FROM tree WHERE dist_ray($ray) <= 1')"
run -c "SELECT measured('nearest 10 without index', 'SELECT * FROM tree ORDER BY dist_ray($ray) + 0 LIMIT 10')"
run -c "SELECT measured('ray of 1 m without index', 'SELECT * FROM tree WHERE dist_ray($ray)::float8 <= 1')"
echo "load after: $(cut -d' ' -f1-3 /proc/loadavg)"
