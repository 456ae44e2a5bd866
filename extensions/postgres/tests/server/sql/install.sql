-- The extension in a schema of its own, which is not searched.
CREATE SCHEMA clouds;
CREATE EXTENSION alidade_pg SCHEMA clouds;
SELECT extversion, extrelocatable FROM pg_extension WHERE extname = 'alidade_pg';
CREATE TABLE points AS SELECT i AS x, 0 AS y, 0 AS z FROM generate_series(1, 100000) i;
CREATE INDEX ON points USING brin (clouds.cloud_point(x,y,z)) WITH (pages_per_range = 1);
ANALYZE points;
EXPLAIN (COSTS OFF) SELECT * FROM points WHERE clouds.dist_plane(5,0,0, 1,0,0, x,y,z) OPERATOR(clouds.<) 3.5 AND x > 5;
SELECT * FROM points WHERE clouds.dist_plane(5,0,0, 1,0,0, x,y,z) OPERATOR(clouds.<) 3.5 AND x > 5;
-- Who may read a view or add rows needs no right to the schema that the view and a CHECK of the table use.
CREATE TABLE checked(x float8, y float8, z float8, CHECK (clouds.dist_ray(0,0,0, 1,0,0, x,y,z) OPERATOR(clouds.<=) 1));
CREATE VIEW distances AS SELECT *, clouds.dist_ray(0,0,0, 1,0,0, x,y,z) AS d FROM points;
CREATE VIEW near_points AS SELECT * FROM points WHERE clouds.dist_ray(1,0,0, 0,1,0, x,y,z) OPERATOR(clouds.<=) 2;
CREATE ROLE reader;
GRANT SELECT ON distances, near_points TO reader;
GRANT INSERT ON checked TO reader;
SET ROLE reader;
SELECT max(d::float8) FROM distances;
SELECT * FROM near_points;
INSERT INTO checked VALUES (7, 0, 1);
INSERT INTO checked VALUES (7, 0, 2);
RESET ROLE;
-- Moved: planned anew, with what lies there now.
PREPARE near AS SELECT count(*) FROM points WHERE clouds.dist_plane(5,0,0, 1,0,0, x,y,z) OPERATOR(clouds.<) 3.5;
EXECUTE near;
ALTER EXTENSION alidade_pg SET SCHEMA public;
SET enable_seqscan = off;
EXPLAIN (COSTS OFF) SELECT * FROM points WHERE dist_plane(5,0,0, 1,0,0, x,y,z) < 3.5;
-- A part that was renamed is not found: statements stay as they are, and right.
ALTER FUNCTION cloud_limit(cloud_plane, text, float8) RENAME TO other;
EXPLAIN (COSTS OFF) SELECT * FROM points WHERE dist_plane(5,0,0, 1,0,0, x,y,z) < 3.5;
ALTER FUNCTION cloud_plane(float8, float8, float8, float8, float8, float8) RENAME TO another;
EXPLAIN (COSTS OFF) SELECT * FROM points WHERE dist_plane(5,0,0, 1,0,0, x,y,z) < 3.5;
SELECT count(*) FROM points WHERE dist_plane(5,0,0, 1,0,0, x,y,z) < 3.5;
-- Functions say what they are.
SELECT provolatile, proisstrict, proparallel, count(*) FROM pg_proc p JOIN pg_depend d ON d.objid = p.oid AND d.deptype = 'e'
  JOIN pg_extension e ON e.oid = d.refobjid AND e.extname = 'alidade_pg' GROUP BY 1, 2, 3 ORDER BY 1, 2, 3;
DROP EXTENSION alidade_pg;
DROP EXTENSION alidade_pg CASCADE;
SELECT count(*) FROM pg_proc WHERE probin LIKE '%alidade%';
DROP OWNED BY reader;
DROP ROLE reader;
