-- Rows and limits that are not ordinary numbers: through an index the same rows match as without.
CREATE EXTENSION alidade_pg;
CREATE TABLE cloud(id int, x float8, y float8, z float8);
INSERT INTO cloud SELECT i, i % 10, i / 10 % 10, i / 100 FROM generate_series(0, 999) i;
INSERT INTO cloud VALUES (1000, 'NaN', 1, 1), (1001, 1, 'Infinity', 1), (1002, 1, 1, '-Infinity'), (1003, NULL, 1, 1), (1004, NULL, NULL, NULL),
  (1005, 1e308, -1e308, 1e308), (1006, -0.0, 0.0, -0.0), (1007, 5e-324, 0, 0), (1008, 'NaN', 'NaN', 'NaN'), (1009, 1e154, 1e154, 1e154);
CREATE TABLE brin AS SELECT * FROM cloud;
CREATE INDEX ON brin USING brin (cloud_point(x,y,z)) WITH (pages_per_range = 1);
CREATE TABLE gist AS SELECT * FROM cloud;
CREATE INDEX ON gist USING gist (cloud_point(x,y,z));

-- How many statements give how many wrong answers, of those the index was asked for.
CREATE FUNCTION wrong(relation text) RETURNS TABLE (statements int, indexed int, differences int) LANGUAGE plpgsql AS $$
DECLARE
  call text; symbol text; bound text; line text; expected bigint[]; found bigint[];
BEGIN
  statements := 0; indexed := 0; differences := 0;
  SET LOCAL enable_seqscan = off;
  FOREACH call IN ARRAY ARRAY['dist_ray(0,0,1, 1,0,0, x,y,z)', 'dist_ray(4,4,0, 1e-200,0,1e-200, x,y,z)', 'dist_ray(1e6,1e6,1e6, 1,1,1, x,y,z)',
                              'dist_plane(1,1,1, 0,0,1e-300, x,y,z)', 'dist_plane(0,0,0, 1,-1,1, x,y,z)',
                              'dist_plane(-1e308,0,0, 0,0,1, x,y,z)', 'dist_plane(0,1e308,0, 1,0,0, x,y,z)'] LOOP
    FOREACH symbol IN ARRAY ARRAY['<', '<=', '=', '>=', '>'] LOOP
      FOREACH bound IN ARRAY ARRAY['0', '-0', '1', '-1', '1.4142135623730951', '1e308', '5e-324', 'Infinity', '-Infinity', 'NaN', NULL] LOOP
        EXECUTE format('SELECT coalesce(array_agg(id ORDER BY id), ''{}'') FROM cloud WHERE %s::float8 %s %L::float8', call, symbol, bound) INTO expected;
        EXECUTE format('SELECT coalesce(array_agg(id ORDER BY id), ''{}'') FROM %I WHERE %s %s %L::float8', relation, call, symbol, bound) INTO found;
        statements := statements + 1;
        IF found <> expected THEN differences := differences + 1; RAISE NOTICE '% % %: % not %', call, symbol, bound, found, expected; END IF;
        EXECUTE format('SELECT coalesce(array_agg(id ORDER BY id), ''{}'') FROM cloud WHERE NOT %s::float8 %s %L::float8', call, symbol, bound) INTO expected;
        EXECUTE format('SELECT coalesce(array_agg(id ORDER BY id), ''{}'') FROM %I WHERE NOT %s %s %L::float8', relation, call, symbol, bound) INTO found;
        statements := statements + 1;
        IF found <> expected THEN differences := differences + 1; RAISE NOTICE 'NOT % % %: % not %', call, symbol, bound, found, expected; END IF;
        FOR line IN EXECUTE format('EXPLAIN SELECT * FROM %I WHERE NOT %s %s %L::float8', relation, call, symbol, bound) LOOP
          IF line LIKE '%Index Cond%' THEN indexed := indexed + 1; END IF;
        END LOOP;
      END LOOP;
    END LOOP;
  END LOOP;
  RETURN NEXT;
END $$;
SELECT * FROM wrong('brin');
SELECT * FROM wrong('gist');
-- Later rows lie in pages of which the index knows nothing, until it is told.
INSERT INTO cloud SELECT i, i % 7, i / 7 % 7, i FROM generate_series(1010, 1999) i;
INSERT INTO brin SELECT * FROM cloud WHERE id >= 1010;
INSERT INTO gist SELECT * FROM cloud WHERE id >= 1010;
SELECT * FROM wrong('brin');
SELECT * FROM wrong('gist');
SELECT brin_summarize_new_values('brin_cloud_point_idx') > 0;
DELETE FROM cloud WHERE id % 3 = 0;
DELETE FROM brin WHERE id % 3 = 0;
DELETE FROM gist WHERE id % 3 = 0;
UPDATE cloud SET x = x + 100 WHERE id % 5 = 0;
UPDATE brin SET x = x + 100 WHERE id % 5 = 0;
UPDATE gist SET x = x + 100 WHERE id % 5 = 0;
VACUUM ANALYZE brin, gist;
SELECT * FROM wrong('brin');
SELECT * FROM wrong('gist');

-- NaN lies above all numbers, as PostgreSQL has it: a radius of NaN keeps all rows that have a place.
SELECT count(*) FROM cloud WHERE x IS NOT NULL;
SELECT count(*) FROM brin WHERE dist_ray(0,0,1, 1,0,0, x,y,z) <= 'NaN';
-- The order of points: one for equal numbers, none before itself, NaN and NULL last.
SELECT count(*) FROM cloud a, cloud b WHERE (cloud_point(a.x,a.y,a.z) = cloud_point(b.x,b.y,b.z)) <> (row(a.x,a.y,a.z) = row(b.x,b.y,b.z));
SELECT count(*) FROM cloud a, cloud b
WHERE (cloud_point(a.x,a.y,a.z) < cloud_point(b.x,b.y,b.z))::int + (cloud_point(a.x,a.y,a.z) = cloud_point(b.x,b.y,b.z))::int
      + (cloud_point(a.x,a.y,a.z) > cloud_point(b.x,b.y,b.z))::int <> 1
   OR (cloud_point(a.x,a.y,a.z) <= cloud_point(b.x,b.y,b.z)) <> (NOT cloud_point(a.x,a.y,a.z) > cloud_point(b.x,b.y,b.z))
   OR (cloud_point(a.x,a.y,a.z) >= cloud_point(b.x,b.y,b.z)) <> (cloud_point(b.x,b.y,b.z) <= cloud_point(a.x,a.y,a.z));
SELECT array_agg(p ORDER BY p) FROM (SELECT cloud_point(x,y,z) AS p FROM generate_series(-1, 0) x, generate_series(0, 1) y, generate_series(0, 1) z) s;
SELECT cloud_point(0,0,0.2e-6) < cloud_point(0,0,0.3e-6), cloud_point(1e15,0,0) < cloud_point(2e15,0,0), cloud_point(1e300,0,0) < cloud_point('NaN',0,0);
-- A range of pages whose box overflows at one end has a row that matches.
CREATE TABLE wide(id int, x float8, y float8, z float8);
INSERT INTO wide VALUES (1, -1e308, 0, 0), (2, 0, 0, 0);
CREATE INDEX ON wide USING brin (cloud_point(x,y,z));
SET enable_seqscan = off;
EXPLAIN (COSTS OFF) SELECT id FROM wide WHERE dist_plane(1e308,0,0, 0,0,1, x,y,z) >= 1000;
SELECT id FROM wide WHERE dist_plane(1e308,0,0, 0,0,1, x,y,z) >= 1000;
