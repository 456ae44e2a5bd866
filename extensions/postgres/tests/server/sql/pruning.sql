-- The paper's statement, and others, as conditions on an index.
\i sql/site.sql
SELECT opcname, amvalidate(oid) FROM pg_opclass WHERE opcname LIKE 'cloud%' ORDER BY opcname;
SELECT round(correlation::numeric, 2) FROM pg_stats WHERE tablename = 'points_brin';

EXPLAIN (COSTS OFF) SELECT * FROM points WHERE dist_ray(0,100,1.5, 1,0.2,0, x,y,z) <= 1;
SELECT pages_read('SELECT * FROM points WHERE dist_ray(0,100,1.5, 1,0.2,0, x,y,z) <= 1') < 0.15;
-- as the paper writes it, with the half-line
EXPLAIN (COSTS OFF) SELECT *
FROM points
WHERE dist_ray(0,100,1.5, 1,0.2,0, x,y,z) <= 1 AND dist_plane(0,100,1.5, 1,0.2,0, x,y,z) >= 0;

-- The same condition said differently finds the same points. In the first row no index is possible.
CREATE VIEW d AS SELECT *, dist_ray(0,100,1.5, 1,0.2,0, x,y,z) AS ray, dist_plane(0,100,1.5, 1,0.2,0, x,y,z) AS plane FROM points;
SELECT count(*) FILTER (WHERE ray::float8 <= 1), count(*) FILTER (WHERE plane::float8 BETWEEN 20 AND 30),
       count(*) FILTER (WHERE ray::float8 <= 1 AND plane::float8 BETWEEN 20 AND 30),
       count(*) FILTER (WHERE ray::float8 <= 1 OR plane::float8 > 195),
       count(*) FILTER (WHERE NOT ray::float8 <= 100) FROM d;
SELECT (SELECT count(*) FROM d WHERE ray <= 1), (SELECT count(*) FROM d WHERE 1 >= ray),
       (SELECT count(*) FROM d WHERE NOT ray > 1), (SELECT count(*) FROM d WHERE NOT 1 < ray),
       (SELECT count(*) FROM d WHERE ray <= 1::real), (SELECT count(*) FROM d WHERE ray <= 1.0),
       (SELECT count(*) FROM d WHERE ray <= '1'), (SELECT count(*) FROM d WHERE ray <= 0.5 + 0.5),
       (SELECT count(*) FROM d WHERE cloud_point(x,y,z) <@ ray_limit(0,100,1.5, 1,0.2,0, '-Infinity', 1)),
       (SELECT count(*) FROM d WHERE cloud_point(x,y,z) <@ 'ray(0, 100, 1.5, 1, 0.2, 0, 0, 1)');
SELECT (SELECT count(*) FROM d WHERE plane BETWEEN 20 AND 30), (SELECT count(*) FROM d WHERE NOT (plane < 20 OR plane > 30)),
       (SELECT count(*) FROM d WHERE cloud_point(x,y,z) <@ plane_limit(0,100,1.5, 1,0.2,0, 20, 30)),
       (SELECT count(*) FROM d WHERE plane BETWEEN SYMMETRIC 30 AND 20);
SELECT (SELECT count(*) FROM d WHERE ray <= 1 AND plane BETWEEN 20 AND 30), (SELECT count(*) FROM d WHERE ray <= 1 OR plane > 195),
       (SELECT count(*) FROM d WHERE NOT ray <= 100), (SELECT count(*) FROM d WHERE ray > 100);
-- Equality finds a point by its own distance, and only it.
SELECT count(*) FROM points WHERE dist_ray(0,100,1.5, 1,0.2,0, x,y,z) = (SELECT min(ray) FROM d);
SELECT count(*) FROM points WHERE dist_ray(0,100,1.5, 1,0.2,0, x,y,z) < (SELECT min(ray) FROM d);

EXPLAIN (COSTS OFF) SELECT * FROM d WHERE 1 > ray;
EXPLAIN (COSTS OFF) SELECT * FROM d WHERE NOT ray > 1;
EXPLAIN (COSTS OFF) SELECT * FROM d WHERE ray = 1;
EXPLAIN (COSTS OFF) SELECT * FROM d WHERE ray <= 1 AND plane BETWEEN 20 AND 30;
EXPLAIN (COSTS OFF) SELECT * FROM d WHERE ray <= 1 OR plane > 195;
EXPLAIN (COSTS OFF) SELECT * FROM d WHERE NOT ray <= 100;

-- Rays from a table.
CREATE TABLE rays(id, ox, oy, oz, dx, dy, dz) AS
  SELECT i, 0::float8, 20.0 * i, 1.5, 1, 0.1 * i, 0 FROM generate_series(1, 8) i;
ANALYZE rays;
EXPLAIN (COSTS OFF) SELECT r.id, p.id FROM rays r JOIN points p ON dist_ray(r.ox,r.oy,r.oz, r.dx,r.dy,r.dz, p.x,p.y,p.z) <= 0.5;
SELECT r.id, count(*) FROM rays r JOIN points p ON dist_ray(r.ox,r.oy,r.oz, r.dx,r.dy,r.dz, p.x,p.y,p.z) <= 0.5 GROUP BY 1
EXCEPT
SELECT r.id, count(*) FROM rays r, points p WHERE dist_ray(r.ox,r.oy,r.oz, r.dx,r.dy,r.dz, p.x,p.y,p.z)::float8 <= 0.5 GROUP BY 1;
SELECT r.id, count(p.id) FROM rays r LEFT JOIN points p ON dist_ray(r.ox,r.oy,r.oz, r.dx,r.dy,r.dz, p.x,p.y,p.z) <= 0.02 * r.id
GROUP BY 1 ORDER BY 1;

-- Prepared, with one plan for all parameters.
SET plan_cache_mode = force_generic_plan;
PREPARE beam AS SELECT count(*) FROM points WHERE dist_ray($1,$2,$3, $4,$5,$6, x,y,z) <= $7;
EXPLAIN (COSTS OFF) EXECUTE beam(0,100,1.5, 1,0.2,0, 1);
EXECUTE beam(0,100,1.5, 1,0.2,0, 1);
EXECUTE beam(0,100,1.5, 1,0.2,0, 1.5::real);
EXECUTE beam(0,100,1.5, 1,0.2,0, NULL);
RESET plan_cache_mode;

-- Distances are numbers.
SELECT pg_typeof(ray), round(avg(ray)::numeric, 6), round(min(plane)::numeric, 6), round((max(ray) - 1)::numeric, 6), sum(ray) > 0
FROM d GROUP BY 1;
SELECT id, round(ray::numeric, 4) FROM d ORDER BY ray, id LIMIT 3;
SELECT count(*) FROM d WHERE ray < plane;
-- Conditions that may differ from row to row stay as they are.
EXPLAIN (COSTS OFF) SELECT * FROM points WHERE dist_ray(0,100,1.5, 1,0.2,0, x,y,z) <= random();

-- How many rows are expected: within a factor of five where it matters.
CREATE FUNCTION expected_rows(statement text) RETURNS float8 LANGUAGE plpgsql AS $$
DECLARE plan json;
BEGIN
  EXECUTE 'EXPLAIN (FORMAT JSON) ' || statement INTO plan;
  RETURN plan->0->'Plan'->>'Plan Rows';
END $$;
SELECT condition, expected_rows('SELECT * FROM d WHERE ' || condition)
                  / (xpath('/row/n/text()', query_to_xml('SELECT count(*) AS n FROM d WHERE ' || condition, true, true, '')))[1]::text::float8
                  BETWEEN 0.2 AND 5 AS near
FROM (VALUES ('ray <= 1'), ('ray <= 5'), ('ray <= 50'), ('ray > 50'), ('plane >= 0'), ('plane >= 100'), ('plane BETWEEN 20 AND 30'),
             ('NOT plane >= 100'), ('ray <= 1000')) AS v(condition);
SELECT expected_rows('SELECT * FROM d WHERE ray <= -1'), expected_rows('SELECT * FROM d WHERE plane > 1e6');
-- Not known before the statement runs: one side of a plane is much, a cylinder little.
PREPARE beyond(float8) AS SELECT * FROM d WHERE plane >= $1;
PREPARE near(float8) AS SELECT * FROM d WHERE ray <= $1;
SET plan_cache_mode = force_generic_plan;
SELECT round((expected_rows('EXECUTE beyond(0)') / count(*))::numeric, 3), round((expected_rows('EXECUTE near(1)') / count(*))::numeric, 3) FROM points;
RESET plan_cache_mode;

-- In parallel.
SET max_parallel_workers_per_gather = 2;
SET parallel_setup_cost = 0;
SET parallel_tuple_cost = 0;
SET min_parallel_table_scan_size = 0;
EXPLAIN (COSTS OFF) SELECT count(*) FROM d WHERE ray <= 1;
SELECT count(*) FROM d WHERE ray <= 1;
