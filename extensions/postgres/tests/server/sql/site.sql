-- What the other files ask: 100,000 points in a block of 200 x 200 x 20 m, in Morton order.
CREATE EXTENSION alidade_pg;
CREATE FUNCTION share(i int, axis int) RETURNS float8 IMMUTABLE AS
  'SELECT (hashint4extended(i, axis) & 1048575) / 1048576.0::float8' LANGUAGE sql;
CREATE TABLE staging AS
  SELECT i AS id, 200 * share(i, 1) AS x, 200 * share(i, 2) AS y, 20 * share(i, 3) AS z FROM generate_series(1, 100000) i;
CREATE TABLE points(id bigint, x float8 NOT NULL, y float8 NOT NULL, z float8 NOT NULL,
  CHECK (x > '-Infinity' AND x < 'Infinity' AND y > '-Infinity' AND y < 'Infinity' AND z > '-Infinity' AND z < 'Infinity'));
INSERT INTO points SELECT * FROM staging ORDER BY cloud_point(x,y,z);
CREATE INDEX points_brin ON points USING brin (cloud_point(x,y,z)) WITH (pages_per_range = 2, autosummarize = on);
-- With this target ANALYZE looks at all rows, and so always finds the same.
SET default_statistics_target = 400;
ANALYZE points;
-- Share of the table's pages that a statement reads.
CREATE FUNCTION pages_read(statement text) RETURNS float8 LANGUAGE plpgsql AS $$
DECLARE plan json;
BEGIN
  EXECUTE 'EXPLAIN (ANALYZE, BUFFERS, TIMING OFF, FORMAT JSON) ' || statement INTO plan;
  RETURN ((plan->0->'Plan'->>'Shared Hit Blocks')::float8 + (plan->0->'Plan'->>'Shared Read Blocks')::float8)
         / (pg_relation_size('points') / 8192);
END $$;
