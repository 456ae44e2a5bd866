-- GiST: few of many, and the nearest first.
\i sql/site.sql
DROP INDEX points_brin;
CREATE INDEX points_gist ON points USING gist (cloud_point(x,y,z));
ANALYZE points;
EXPLAIN (COSTS OFF) SELECT * FROM points WHERE dist_ray(0,100,1.5, 1,0.2,0, x,y,z) <= 1;
EXPLAIN (COSTS OFF) SELECT id FROM points ORDER BY dist_ray(0,100,1.5, 1,0.2,0, x,y,z) LIMIT 10;
EXPLAIN (COSTS OFF) SELECT id FROM points ORDER BY cloud_point(x,y,z) <-> cloud_ray(0,100,1.5, 1,0.2,0) LIMIT 10;
-- The first hits of a beam.
EXPLAIN (COSTS OFF) SELECT id FROM points WHERE dist_ray(0,100,1.5, 1,0.2,0, x,y,z) <= 1 AND dist_plane(0,100,1.5, 1,0.2,0, x,y,z) >= 0
ORDER BY dist_plane(0,100,1.5, 1,0.2,0, x,y,z) LIMIT 3;

CREATE TABLE nearest AS SELECT id, dist_ray(0,100,1.5, 1,0.2,0, x,y,z) AS d FROM points ORDER BY dist_ray(0,100,1.5, 1,0.2,0, x,y,z) LIMIT 100;
CREATE TABLE first AS SELECT id FROM points WHERE dist_ray(0,100,1.5, 1,0.2,0, x,y,z) <= 1 AND dist_plane(0,100,1.5, 1,0.2,0, x,y,z) >= 0
  ORDER BY dist_plane(0,100,1.5, 1,0.2,0, x,y,z) LIMIT 20;
SELECT count(*) FROM points WHERE NOT dist_ray(0,100,1.5, 1,0.2,0, x,y,z) > 1;
SELECT pages_read('SELECT id FROM points ORDER BY dist_ray(0,100,1.5, 1,0.2,0, x,y,z) LIMIT 10') < 0.15;

-- Rays from a table, the nearest three of each.
CREATE TABLE rays(id, oy) AS SELECT i, 20.0 * i FROM generate_series(1, 8) i;
EXPLAIN (COSTS OFF) SELECT * FROM rays r, LATERAL
  (SELECT p.id FROM points p ORDER BY dist_ray(0,r.oy,1.5, 1,0.2,0, p.x,p.y,p.z) LIMIT 3) n;
CREATE TABLE by_index AS SELECT r.id AS ray, n.id FROM rays r, LATERAL
  (SELECT p.id FROM points p ORDER BY dist_ray(0,r.oy,1.5, 1,0.2,0, p.x,p.y,p.z) LIMIT 3) n;

SET enable_indexscan = off;
SET enable_bitmapscan = off;
EXPLAIN (COSTS OFF) SELECT id FROM points ORDER BY dist_ray(0,100,1.5, 1,0.2,0, x,y,z) LIMIT 100;
SELECT array_agg(n.id ORDER BY d) = (SELECT array_agg(s.id ORDER BY s.d) FROM
  (SELECT id, dist_ray(0,100,1.5, 1,0.2,0, x,y,z) AS d FROM points ORDER BY d LIMIT 100) s) FROM nearest n;
SELECT array_agg(id) = (SELECT array_agg(s.id) FROM
  (SELECT id FROM points WHERE dist_ray(0,100,1.5, 1,0.2,0, x,y,z)::float8 <= 1 AND dist_plane(0,100,1.5, 1,0.2,0, x,y,z)::float8 >= 0
   ORDER BY dist_plane(0,100,1.5, 1,0.2,0, x,y,z) LIMIT 20) s) FROM first;
SELECT count(*) FROM points WHERE dist_ray(0,100,1.5, 1,0.2,0, x,y,z)::float8 <= 1;
SELECT count(*) FROM by_index;
SELECT r.id AS ray, n.id FROM rays r, LATERAL
  (SELECT p.id FROM points p ORDER BY dist_ray(0,r.oy,1.5, 1,0.2,0, p.x,p.y,p.z) LIMIT 3) n
EXCEPT SELECT * FROM by_index;
RESET enable_indexscan;
RESET enable_bitmapscan;

-- Rows that come later, one by one, split pages; those without a place come last.
CREATE TABLE walls(id int, x float8, y float8, z float8);
CREATE INDEX walls_gist ON walls USING gist (cloud_point(x,y,z));
INSERT INTO walls SELECT i, i % 50, 0, i / 50 % 40 FROM generate_series(0, 9999) i;
INSERT INTO walls VALUES (10000, 'NaN', 0, 0), (10001, 'Infinity', 0, 0), (10002, NULL, 0, 0), (10003, 3, '-Infinity', 0);
SET enable_seqscan = off;
EXPLAIN (COSTS OFF) SELECT id FROM walls WHERE dist_ray(10,0,20, 0,1,0, x,y,z) <= 2;
SELECT count(*) FROM walls WHERE dist_ray(10,0,20, 0,1,0, x,y,z) <= 2;
SELECT array_agg(d) = (SELECT array_agg(s.d) FROM (SELECT dist_ray(10,0,20, 0,1,0, x,y,z) + 0 AS d FROM walls ORDER BY d LIMIT 500) s)
FROM (SELECT dist_ray(10,0,20, 0,1,0, x,y,z) + 0 AS d FROM walls ORDER BY dist_ray(10,0,20, 0,1,0, x,y,z) LIMIT 500) n;
EXPLAIN (COSTS OFF) SELECT id FROM walls ORDER BY dist_ray(10,0,20, 0,1,0, x,y,z);
SELECT array_agg(id ORDER BY id) FROM (SELECT id FROM walls ORDER BY dist_ray(10,0,20, 0,1,0, x,y,z) OFFSET 10000) n;
SET enable_bitmapscan = off;
SET enable_indexscan = off;
SELECT count(*) FROM walls WHERE dist_ray(10,0,20, 0,1,0, x,y,z)::float8 <= 2;
RESET enable_bitmapscan;
RESET enable_indexscan;
-- Many equal points, and two columns.
CREATE TABLE same(x float8, y float8, z float8, class int);
CREATE INDEX same_gist ON same USING gist (cloud_point(x,y,z), cloud_point(z,y,x));
INSERT INTO same SELECT 1, 2, 3, i % 5 FROM generate_series(1, 3000) i;
EXPLAIN (COSTS OFF) SELECT count(*) FROM same WHERE dist_ray(1,2,0, 0,0,1, x,y,z) <= 0 AND dist_ray(1,2,0, 0,0,1, z,y,x) >= 1;
SELECT count(*) FROM same WHERE dist_ray(1,2,0, 0,0,1, x,y,z) <= 0 AND dist_ray(1,2,0, 0,0,1, z,y,x) >= 1;
