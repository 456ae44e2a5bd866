SELECT id FROM points WHERE dist_ray(0,0,0,1,0,0,x,y,z) <= 1 + 6
