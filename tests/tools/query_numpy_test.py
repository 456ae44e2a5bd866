# SPDX-License-Identifier: MIT
# query_numpy_test.py CLOUD.las RAYS.csv RADIUS K MEASURE: what `alidade query` answers, by looking at the points.
# All arithmetic is that of octree/distance.h in its order, so that answers are the same bits. Points are sorted by x only
# to look at those a ray of limited length can reach.
import sys, numpy as np
las, radius, k, measure = open(sys.argv[1], 'rb').read(), float(sys.argv[3]), int(sys.argv[4]), sys.argv[5]
start, size, count = (int(np.frombuffer(las, kind, 1, at)[0]) for kind, at in (('<u4', 96), ('<u2', 105), ('<u4', 107)))
lattice = np.frombuffer(las, '<f8', 6, 131)
points = lattice[3:] + lattice[:3] * np.ndarray((count, 3), '<i4', las, start, (size, 4))
ids = np.argsort(points[:, 0])
points = points[ids]
print('ray_id,rank,point_id,x,y,z,t,distance,entry')
for ray_id, (ox, oy, oz, dx, dy, dz, t_min, t_max) in enumerate(np.loadtxt(sys.argv[2], delimiter=',', skiprows=1)):
    d = np.array([dx, dy, dz]) / max(abs(dx), abs(dy), abs(dz))
    d = d / np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
    ends = sorted((ox + t_min * d[0], ox + t_max * d[0]))
    near = slice(*np.searchsorted(points[:, 0], (ends[0] - 2 * radius, ends[1] + 2 * radius)))
    x, y, z = (points[near] - (ox, oy, oz)).T
    cx, cy, cz = y * d[2] - z * d[1], z * d[0] - x * d[2], x * d[1] - y * d[0]
    t, distance = x * d[0] + y * d[1] + z * d[2], np.sqrt(cx * cx + cy * cy + cz * cz)
    entry = t - np.sqrt(np.maximum(radius * radius - distance * distance, 0))
    found = np.flatnonzero((distance <= radius) & (t >= t_min) & (t <= t_max))
    value = {'t': t, 'distance': distance, 'entry': entry}[measure][found]
    for rank, i in enumerate(found[np.lexsort((ids[near][found], value))][:k]):
        numbers = (*points[near][i], t[i], distance[i], entry[i])
        print(ray_id, rank, ids[near][i], *('%.17g' % number for number in numbers), sep=',')
