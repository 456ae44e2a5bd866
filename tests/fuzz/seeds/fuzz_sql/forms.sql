SELECT * FROM points WHERE dist_ray(0,0,0, 1,0,0, x,y,z) <= 1 AND NOT dist_plane(0,0,0, 0,0,1, x,y,z) BETWEEN 0 AND 2
