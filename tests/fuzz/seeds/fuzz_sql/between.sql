SELECT id FROM points WHERE 1 BETWEEN 0 AND dist_ray(0,0,0,1,0,0,x,y,z) = 1 AND id < 9
