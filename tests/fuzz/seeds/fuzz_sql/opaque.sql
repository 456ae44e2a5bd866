SELECT count(*), 'it''s' FROM points WHERE CASE WHEN dist_ray(0,0,0,1,0,0,x,y,z) < 2 AND 1 THEN x'00' END OR NOT dist_ray(0,0,0,1,0,0,x,y,z) <= 7 = 0 GROUP BY x HAVING 1 ORDER BY 1
