-- A distance goes wherever a double goes.
CREATE EXTENSION alidade_pg;
CREATE TABLE points(x, y, z) AS SELECT i % 3, i % 2, i FROM generate_series(1, 6) i;
CREATE VIEW d AS SELECT dist_ray(0,0,0, 0,0,1, x,y,z) AS ray, dist_plane(0,0,3, 0,0,1, x,y,z) AS plane, z FROM points;
SELECT ray + 1, 2 * ray, -plane, plane / 2.0, plane ^ 2, abs(plane), sqrt(ray), round(ray), round(ray::numeric, 3), plane::int, plane::smallint, plane::bigint, ray::real
FROM d WHERE z = 5;
SELECT sum(plane), avg(plane), min(plane), max(plane), count(DISTINCT plane), stddev(plane) > 1 FROM d;
SELECT percentile_cont(0.5) WITHIN GROUP (ORDER BY plane), array_agg(plane ORDER BY plane DESC) FROM d;
SELECT ray, count(*) FROM d GROUP BY ray ORDER BY ray;
SELECT DISTINCT ray FROM d ORDER BY 1;
SELECT z, rank() OVER (PARTITION BY ray ORDER BY plane) FROM d ORDER BY z;
-- Where SQL looks for a common type of several numbers, it wants a word.
SELECT ray::float8 FROM d UNION SELECT 7 ORDER BY 1;
SELECT coalesce(plane::float8, 0), greatest(plane::float8, 1), CASE WHEN plane > 0 THEN plane::float8 ELSE 0 END FROM d WHERE z = 1;
SELECT coalesce(plane, 0) FROM d;
SELECT z FROM d WHERE plane IN (-2, 3) ORDER BY z;
SELECT z FROM d WHERE plane = ANY ('{-1,0}') ORDER BY z;
SELECT z FROM d WHERE plane <> 0 AND plane <> 1::real AND plane < 2::numeric AND plane > '-2' AND plane >= -1::smallint ORDER BY z;
SELECT z FROM d WHERE plane < ray AND plane = plane AND ray >= plane ORDER BY z;
SELECT z FROM d JOIN generate_series(0, 1) g ON d.plane = g ORDER BY z;
SELECT z FROM d JOIN (VALUES (0.0::float8), (2.0)) v(at) ON v.at = d.plane ORDER BY z;
CREATE TABLE kept(a float8, b real, c numeric(6, 2), d int, e cloud_distance);
INSERT INTO kept SELECT ray, ray, ray, plane, ray FROM d WHERE z = 5;
INSERT INTO kept VALUES (1, 1, 1, 1, 1), (2, 2, 2, 2, 2.5);
UPDATE kept SET e = a WHERE d = 1;
SELECT * FROM kept ORDER BY e;
CREATE TABLE generated(x float8, y float8, z float8, height cloud_distance GENERATED ALWAYS AS (dist_plane(0,0,0, 0,0,1, x,y,z)) STORED);
INSERT INTO generated VALUES (1, 2, 3);
CREATE INDEX ON generated (height);
SELECT * FROM generated WHERE height > 2;
-- Casts that round, and domains, keep their say when a function is inlined.
CREATE FUNCTION whole_metres(x float8, y float8, z float8) RETURNS integer LANGUAGE sql IMMUTABLE AS 'SELECT dist_ray(0,0,0, 1,0,0, x,y,z)';
CREATE TABLE quarters AS SELECT i * 0.25::float8 AS x, i * 0.25::float8 AS y, 0::float8 AS z FROM generate_series(1, 100) i;
SELECT count(*) FROM quarters WHERE whole_metres(x,y,z) <= 3::cloud_distance;
SELECT count(*) FROM (SELECT whole_metres(x,y,z) AS whole FROM quarters OFFSET 0) s WHERE whole <= 3::cloud_distance;
CREATE DOMAIN near AS cloud_distance CHECK (VALUE < 5);
CREATE FUNCTION is_near(v near) RETURNS boolean LANGUAGE sql IMMUTABLE AS 'SELECT v <= 100::float8';
SELECT count(*) FROM quarters WHERE is_near(dist_ray(0,0,0, 1,0,0, x,y,z));
-- Stored distances are found by an index on them, and joined as doubles are.
CREATE TABLE stored AS SELECT i AS id, dist_plane(0,0,0, 1,0,0, i,0,0) AS d FROM generate_series(1, 1000) i;
CREATE INDEX ON stored(d);
ANALYZE stored;
EXPLAIN (COSTS OFF) SELECT id FROM stored WHERE d = 3;
EXPLAIN (COSTS OFF) SELECT id FROM stored WHERE 3.5 > d;
SELECT count(*) FILTER (WHERE d < 3), count(*) FILTER (WHERE d <= 3), count(*) FILTER (WHERE d = 3), count(*) FILTER (WHERE d >= 3),
       count(*) FILTER (WHERE d > 3), count(*) FILTER (WHERE 3 > d), count(*) FILTER (WHERE 3 >= d) FROM stored;
EXPLAIN (COSTS OFF) SELECT count(*) FROM stored a JOIN stored b USING (d);
SELECT count(*) FROM stored a JOIN stored b USING (d);
SELECT count(*) FROM stored a FULL JOIN stored b ON a.d = b.d;
