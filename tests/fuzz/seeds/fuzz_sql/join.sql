SELECT p.id FROM rays r LEFT JOIN points p ON dist_ray(r.ox,r.oy,r.oz, r.dx,r.dy,r.dz, p.x,"p".[y],`p`.z) < r.r /* ) */ WHERE ? >= dist_plane(0,0,0,1,1,?,p.x,p.y,p.z) OR (p.id = 2) -- (
