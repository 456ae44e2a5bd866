-- What must be an error, what gives NULL, what no rows.
CREATE EXTENSION alidade_pg;
CREATE TABLE points(x float8, y float8, z float8);
-- Directions, normals and places: raised when the statement is planned, so on an empty table too.
SELECT * FROM points WHERE dist_ray(0,0,0, 0,0,0, x,y,z) <= 1;
SELECT * FROM points WHERE dist_ray(0,0,0, 'NaN',0,0, x,y,z) <= 1;
SELECT * FROM points WHERE dist_ray(0,0,0, 1,'-Infinity',0, x,y,z) <= 1;
SELECT * FROM points WHERE dist_ray('NaN',0,0, 1,0,0, x,y,z) <= 1;
SELECT * FROM points WHERE dist_ray(0,'Infinity',0, 1,0,0, x,y,z) <= 1;
SELECT * FROM points WHERE dist_plane(0,0,0, 0,0,0, x,y,z) >= 0;
SELECT * FROM points WHERE dist_plane(0,0,0, 0,'NaN',0, x,y,z) >= 0;
SELECT * FROM points WHERE dist_plane(0,0,0, 0,0,'Infinity', x,y,z) >= 0;
SELECT * FROM points WHERE dist_plane(0,0,'NaN', 1,0,0, x,y,z) >= 0;
SELECT * FROM points WHERE dist_plane(0,0,'Infinity', 1,0,0, x,y,z) >= 0;
SELECT dist_ray(0,0,0, 0,0,0, 1,2,3);
SELECT dist_plane(0,0,0, 0,0,0, 1,2,3);
SELECT cloud_ray(0,0,0, 0,0,0);
SELECT cloud_plane(0,0,0, 0,0,0);
SELECT ray_limit(0,0,0, 0,0,0, 0, 1);
SELECT plane_limit(0,0,0, 0,0,0, 0, 1);
-- The message is whole where the direction comes from a row.
SELECT dist_ray(0,0,0, d,0,0, 1,2,3) FROM (VALUES (1.0), (0.0)) v(d) OFFSET 0;
-- Any length but zero.
SELECT dist_ray(0,0,0, 1e-300,0,0, 1,3,4), dist_ray(0,0,0, 1e300,0,0, 1,3,4), dist_plane(0,0,0, -5e-324,0,0, 1,3,4);
-- NULL anywhere, also as radius, in rows too: no error, no match.
INSERT INTO points VALUES (1,2,3), (NULL,2,3), (1,NULL,3), (1,2,NULL);
SELECT dist_ray(NULL,0,0, 1,0,0, 1,2,3), dist_ray(0,0,0, 1,0,NULL, 1,2,3), dist_ray(0,0,0, 1,0,0, 1,2,NULL), dist_plane(0,0,0, NULL,0,0, 1,2,3);
SELECT dist_ray(NULL,0,0, 0,0,0, 1,2,3), cloud_point(1,NULL,2), cloud_ray(0,0,0, 1,0,NULL), ray_limit(0,0,0, 1,0,0, 0, NULL);
SELECT * FROM points WHERE dist_ray(0,0,0, 1,0,0, x,y,z) <= NULL;
SELECT * FROM points WHERE dist_ray(0,0,0, 1,0,NULL, x,y,z) <= 100;
SELECT * FROM points WHERE dist_ray(0,0,0, 1,0,0, x,y,z) <= 100;
-- Negative radii and empty ranges: nothing.
SELECT * FROM points WHERE dist_ray(0,0,0, 1,0,0, x,y,z) <= -1;
SELECT * FROM points WHERE dist_plane(0,0,0, 1,0,0, x,y,z) BETWEEN 2 AND 1;
SELECT * FROM points WHERE cloud_point(x,y,z) <@ ray_limit(0,0,0, 1,0,0, 100, 0);
-- Text for a number, and the wrong number of arguments.
SELECT * FROM points WHERE dist_ray(0,0,0, 'north',0,0, x,y,z) <= 1;
SELECT * FROM points WHERE dist_ray(0,0,0, 1,0,0, x,y,z) <= 'near';
SELECT * FROM points WHERE dist_ray(0,0,0, 1,0,0, x,y,z) <= '1'::text;
SELECT * FROM points WHERE dist_ray(0,0,0, '1',0,0, x,y,z) <= '100';
SELECT dist_ray(0,0,0, 1,0,0, 1,2);
SELECT dist_plane(0,0,0, 1,0,0, 1,2,3,4);
SELECT cloud_limit(cloud_ray(0,0,0, 1,0,0), '<>', 1);
SELECT cloud_limit(cloud_ray(0,0,0, 1,0,0), '', 1);
SELECT cloud_limit(cloud_ray(0,0,0, 1,0,0), repeat('<', 100), 1) IS NULL;
-- A table with the check that the manual recommends refuses places that are none.
CREATE TABLE checked(x float8 NOT NULL CHECK (x > '-Infinity' AND x < 'Infinity'));
INSERT INTO checked VALUES ('NaN');
INSERT INTO checked VALUES ('-Infinity');
INSERT INTO checked VALUES (NULL);

-- Texts of values.
SELECT '(1,2,3)'::cloud_point, ' ( 1e3 , -0 , 1e-320 ) '::cloud_point, '(NaN,Infinity,-Infinity)'::cloud_point;
SELECT '(0.1,0.2,0.3,3,4,0)'::cloud_ray, '(690000.123,5325000.456,0,0,0,-2)'::cloud_plane;
SELECT 'ray(0,0,0,1,1,0,-Infinity,1)'::cloud_limit, 'plane(0,0,0,0,0,2,0,NaN)'::cloud_limit;
SELECT '(0,0,0,1,1,1)'::cloud_box, '1.5'::cloud_distance;
CREATE FUNCTION refused(type text, written text) RETURNS text LANGUAGE plpgsql AS $$
BEGIN
  EXECUTE format('SELECT %L::%I::text', written, type) INTO written;
  RETURN 'taken: ' || written;
EXCEPTION WHEN OTHERS THEN
  RETURN SQLSTATE || ' ' || left(SQLERRM, 100);
END $$;
SELECT refused(type, written) FROM (VALUES
  ('cloud_point', ''), ('cloud_point', '()'), ('cloud_point', '(1,2)'), ('cloud_point', '(1,2,3'), ('cloud_point', '(1,2,3,4)'),
  ('cloud_point', '(1,2,3) x'), ('cloud_point', '(1;2;3)'), ('cloud_point', '(a,b,c)'), ('cloud_point', '(1e999,0,0)'), ('cloud_point', '1,2,3'),
  ('cloud_point', '(1,,3)'), ('cloud_point', repeat('(', 100000)), ('cloud_ray', '(0,0,0,0,0,0)'), ('cloud_ray', '(0,0,0,NaN,0,0)'),
  ('cloud_ray', '(Infinity,0,0,1,0,0)'), ('cloud_ray', '(0,0,0,1,0)'), ('cloud_plane', '(0,0,0,0,0,0)'), ('cloud_limit', '(0,0,0,1,0,0,0,1)'),
  ('cloud_limit', 'ray'), ('cloud_limit', 'rays(0,0,0,1,0,0,0,1)'), ('cloud_limit', 'ray(0,0,0,1,0,0,0)'), ('cloud_limit', 'ray(0,0,0,0,0,0,0,1)'),
  ('cloud_limit', 'plane(NaN,0,0,1,0,0,0,1)'), ('cloud_limit', 'pla(0,0,0,1,0,0,0,1)'), ('cloud_box', '(0,0,0,1,-1,1)'), ('cloud_box', '(NaN,0,0,1,1,1)'),
  ('cloud_distance', 'far')) v(type, written);
-- Bytes of values: there and back, and with something wrong.
CREATE TABLE binary_values(p cloud_point, r cloud_ray, n cloud_plane, l cloud_limit, d cloud_distance);
INSERT INTO binary_values VALUES ('(0.1,NaN,-Infinity)', '(1,2,3,4,5,6)', '(1,2,3,0,0,-1e-300)', 'plane(1,2,3,4,5,6,-1,NaN)', 0.1);
CREATE TABLE copied (LIKE binary_values);
\set file `echo "$binary_file"`
COPY binary_values TO :'file' (FORMAT binary);
COPY copied FROM :'file' (FORMAT binary);
SELECT (SELECT b::text FROM binary_values b) = (SELECT c::text FROM copied c);
SELECT cloud_limit_send(l) FROM copied;

-- A direction from a row that has no length is an error also where there is no point, as the manual says.
SELECT dist_ray(0,0,0, d,0,0, x,y,z) FROM (VALUES (1.0), (0.0)) v(d) LEFT JOIN points ON false;
-- Who may not execute a function does not, and one that stands for it in plans is not asked for.
CREATE ROLE stranger;
GRANT SELECT ON points TO stranger;
REVOKE EXECUTE ON FUNCTION dist_ray FROM PUBLIC;
SET ROLE stranger;
SELECT count(*) FROM points WHERE dist_ray(0,0,0, 1,0,0, x,y,z) <= 100;
RESET ROLE;
GRANT EXECUTE ON FUNCTION dist_ray TO PUBLIC;
REVOKE EXECUTE ON FUNCTION cloud_limit(cloud_ray, text, float8) FROM PUBLIC;
SET ROLE stranger;
SELECT count(*) FROM points WHERE dist_ray(0,0,0, 1,0,0, x,y,z) <= 100;
RESET ROLE;
REVOKE EXECUTE ON FUNCTION cloud_ray(float8, float8, float8, float8, float8, float8) FROM PUBLIC;
SET ROLE stranger;
SELECT count(*) FROM points WHERE dist_ray(0,0,0, 1,0,0, x,y,z) <= 100;
RESET ROLE;
DROP OWNED BY stranger;
DROP ROLE stranger;
-- The estimate is for limits; a superuser who gives it to another operator gets one all the same.
CREATE OPERATOR ==== (LEFTARG = integer, RIGHTARG = integer, FUNCTION = int4eq, RESTRICT = cloud_keeping_share);
CREATE TABLE numbers AS SELECT i FROM generate_series(1, 1000) i;
ANALYZE numbers;
SELECT * FROM numbers WHERE i ==== 3;
