# SPDX-License-Identifier: MIT
# query_pictures.py ALIDADE SITE FOLDER [NAME...]: the pictures of docs/queries.md, one for each family of queries. What
# stands around is grey, what a query was asked with is blue, what it found is orange. SITE is the courtyard of
# `alidade generate`; all places here are in metres from its zero (simulation/courtyard.h tells what stands where).
import csv, json, math, os, struct, subprocess, sys, tempfile

ZERO = (690000, 5325000, 600)
ORANGE, BLUE = (245, 100, 10), (16, 64, 230)
YARD = ((2, -15, -0.5), (19, 2, 5))  # paving, two cars, two benches and a sphere on a pole


def add(a, b, factor=1.0):
    return tuple(p + factor * q for p, q in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return tuple(value / math.hypot(*a) for value in a)


def direction(start, end):
    return unit(add(end, start, -1))


def across(axis):
    """Two unit vectors across an axis and each other."""
    a = unit(cross(axis, (0, 0, 1) if abs(axis[2]) < 0.9 else (1, 0, 0)))
    return a, cross(unit(axis), a)


def around(center, axis, radius, count):
    a, b = across(axis)
    turns = [2 * math.pi * i / count for i in range(count)]
    return [add(add(center, a, radius * math.cos(turn)), b, radius * math.sin(turn)) for turn in turns]


def rod(start, end, radius=0.045, color=BLUE):
    """Points all round a straight line."""
    d, step = direction(start, end), 0.03
    places = []
    for i in range(int(math.dist(start, end) / step) + 1):
        places += around(add(start, d, i * step), d, radius, 8)
    return [(place, color) for place in places]


def ring(center, axis, radius):
    corners = around(center, axis, radius, 60)
    return [point for i in range(60) for point in rod(corners[i - 1], corners[i])]


def ball(center, radius, color=BLUE):
    points, count = [], 600
    for i in range(count):
        z, turn = 1 - (2 * i + 1) / count, i * math.pi * (3 - math.sqrt(5))
        level = math.sqrt(1 - z * z)
        points.append((add(center, (level * math.cos(turn), level * math.sin(turn), z), radius), color))
    return points


def box_edges(low, high):
    corners = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    return [rod(a, b) for a in corners for b in corners if a < b and sum(p != q for p, q in zip(a, b)) == 1]


def read_las(file):
    """Place and colour of every point of a LAS 1.4 file in point format 7."""
    data = open(file, 'rb').read()
    start, size, count = (struct.unpack_from(kind, data, at)[0] for kind, at in (('<I', 96), ('<H', 105), ('<Q', 247)))
    lattice = struct.unpack_from('<6d', data, 131)
    for at in range(start, start + count * size, size):
        steps = struct.unpack_from('<3i', data, at)
        yield (tuple(lattice[3 + i] + lattice[i] * steps[i] - ZERO[i] for i in range(3)),
               struct.unpack_from('<3H', data, at + 30))


def write_ply(file, points):
    names = [('double', 'x'), ('double', 'y'), ('double', 'z'), ('uchar', 'red'), ('uchar', 'green'), ('uchar', 'blue')]
    header = ['ply', 'format binary_little_endian 1.0', f'element vertex {len(points)}']
    header += [f'property {kind} {name}' for kind, name in names] + ['end_header\n']
    with open(file, 'wb') as ply:
        ply.write('\n'.join(header).encode())
        for place, color in points:
            ply.write(struct.pack('<3d3B', *place, *color))


def grey(color):
    light = (0.3 * color[0] + 0.6 * color[1] + 0.1 * color[2]) / 65535
    return (175 + 12 * int(4 * light),) * 3


class Painter:
    def __init__(self, program, site, folder, scratch):
        self.program, self.site, self.folder, self.scratch = program, site, folder, scratch

    def run(self, *words):
        subprocess.run([self.program, *words, '-q', '--overwrite'], check=True)

    def query(self, output, option, targets, conditions):
        words = [word for target in targets for word in (option, ','.join(repr(float(value)) for value in target))]
        file = os.path.join(self.scratch, output)
        self.run('query', self.site, *words, *conditions, '-o', file)
        return file

    def find(self, option, targets, *conditions):
        """The found points as places and colours."""
        return list(read_las(self.query('found.las', option, targets, conditions)))

    def rows(self, option, targets, *conditions):
        with open(self.query('found.csv', option, targets, conditions)) as stream:
            return list(csv.DictReader(stream))

    def inside(self, low, high):
        return self.find('--box', [add(low, ZERO) + add(high, ZERO)])

    def picture(self, name, cloud, found, blue, eye, target, fov):
        places = {place for place, _ in found}
        points = [(place, grey(color)) for place, color in cloud if place not in places]
        points += [(place, ORANGE) for place in places]
        for part in blue:
            points += part
        file = os.path.join(self.scratch, 'cloud.ply')
        write_ply(file, points)
        scene = {
            'version': 1,
            'cloud': {'file': file, 'radius': 0.045, 'color': 'rgb', 'normals': 'smooth'},
            'sky': {'type': 'gradient', 'horizon': [0.95, 0.95, 0.95], 'zenith': [0.3, 0.3, 0.3]},
            'sun': {'azimuth': 150, 'elevation': 50, 'irradiance': [1.9, 1.9, 1.9], 'angular_diameter': 0},
            'camera': {'model': 'pinhole', 'width': 480, 'height': 300, 'intrinsics': {'vertical_fov': fov},
                       'pose': {'look_at': {'eye': eye, 'target': target}}},
            'render': {'samples': 160, 'max_bounces': 1},
            'output': {'file': os.path.abspath(os.path.join(self.folder, name + '.jpg'))}}
        file = os.path.join(self.scratch, 'scene.json')
        with open(file, 'w') as stream:
            json.dump(scene, stream)
        self.run('render', file)
        print(f'{name}: {len(found)} of {len(points)} points, {os.path.getsize(scene["output"]["file"])} bytes')


def query_rays(painter):
    """From left to right: all within the radius; those of an interval; the first ones by t."""
    z, start, end, radius = 0.7, -15, 2, 0.9
    found, blue = [], []
    for x, conditions in ((5, ('--t-min', '0', '--t-max', '17')), (10.2, ('--t-min', '4', '--t-max', '9')),
                          (15, ('--t-min', '0', '--measure', 't', '--k', '1200'))):
        found += painter.find('--ray', [add((x, start, z), ZERO) + (0, 1, 0)], '--radius', str(radius), *conditions)
        blue.append(rod((x, start, z), (x, end, z)))
    blue += [ring((10.2, start + t, z), (0, 1, 0), radius) for t in (4, 9)]
    painter.picture('query_rays', painter.inside(*YARD), found, blue, (9, -24, 9), (10, -6.7, 0), 34)


def query_first_hit(painter):
    eye, elevation = (4.5, -13, 1.8), math.radians(-8)
    rays = []
    for degrees in range(12, 97, 7):
        azimuth = math.radians(degrees)
        rays.append((math.cos(azimuth) * math.cos(elevation), math.sin(azimuth) * math.cos(elevation), math.sin(elevation)))
    hits = painter.rows('--ray', [add(eye, ZERO) + ray + (0, 22) for ray in rays], '--radius', '0.05', '--k', '1')
    blue = [ball(eye, 0.3)]
    for hit in hits:
        ray = rays[int(hit['ray_id'])]
        place = add(eye, ray, float(hit['entry']))
        blue += [rod(eye, place, 0.03), ball(place, 0.2, ORANGE)]
    painter.picture('query_first_hit', painter.inside(*YARD), [], blue, (9, -24, 9), (10, -6.7, 0), 34)


def query_cone(painter):
    apex, half_angle, length = (4.5, -14, 3.4), 9, 11.5
    axis = direction(apex, (11.4, -9, 0.7))
    found = painter.find('--cone', [add(apex, ZERO) + axis + (half_angle, 0, 0, length)])
    end, width = add(apex, axis, length), length * math.tan(math.radians(half_angle))
    blue = [ball(apex, 0.2), ring(end, axis, width)] + [rod(apex, place, 0.025) for place in around(end, axis, width, 8)]
    painter.picture('query_cone', painter.inside(*YARD), found, blue, (9, -24, 9), (10, -6.7, 0), 34)


def query_path(painter):
    path = [(-19, -12, 0.5), (-9, -4, 0.5), (4, -9, 0.5), (10.2, 2, 0.5), (19, 5, 0.5)]
    found = painter.find('--vertex', [add(place, ZERO) for place in path], '--radius', '1.2')
    blue = [rod(a, b, 0.08) for a, b in zip(path, path[1:])] + [ball(place, 0.25) for place in path]
    painter.picture('query_path', painter.inside((-24, -17, -0.5), (22, 15, 4)), found, blue, (1, -38, 24), (-0.8, -3.6, 0), 39)


def query_slab(painter):
    x, thickness = -13.3, 0.6
    found = painter.find('--plane', [add((x, 0, 0), ZERO) + (1, 0, 0), add((x + thickness, 0, 0), ZERO) + (-1, 0, 0)])
    found = [point for point in found if -14 < point[0][1] < 25]
    blue = [rod(a, b, 0.07) for a, b in (((x, -14, 0), (x, -14, 13)), ((x, -14, 13), (x, 25, 13)), ((x, 25, 13), (x, 25, 0)))]
    painter.picture('query_slab', painter.inside((-30, -14, -0.5), (x, 25, 14)), found, blue, (30, -8, 11), (-15, 5.3, 4.6), 33)


def query_frustum(painter):
    eye, target, far, half_width, half_height = (17.5, -13.5, 4.5), (9, -5, 0.3), 13.5, 0.42, 0.26
    view = direction(eye, target)
    right, down = across(view)
    corners = [add(add(view, right, h * half_width), down, v * half_height) for h, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    planes = []
    for i in range(4):
        normal = cross(corners[i - 1], corners[i])
        if sum(p * q for p, q in zip(normal, view)) < 0:
            normal = tuple(-value for value in normal)
        planes.append(add(eye, ZERO) + normal)
    planes.append(add(add(eye, view, far), ZERO) + tuple(-value for value in view))
    found = painter.find('--plane', planes)
    ends = [add(eye, corner, far) for corner in corners]
    blue = [ball(eye, 0.25)] + [rod(eye, end) for end in ends] + [rod(ends[i - 1], ends[i]) for i in range(4)]
    painter.picture('query_frustum', painter.inside((0, -15, -0.5), (19, 4, 5)), found, blue, (5, -26, 12), (10.4, -6.4, 0.5), 38)


def query_box(painter):
    low, high = (12.9, -6.1, -0.2), (16.8, -0.8, 2)
    painter.picture('query_box', painter.inside(*YARD), painter.inside(low, high), box_edges(low, high),
                    (9, -24, 9), (10, -6.7, 0), 34)


def query_point(painter):
    place = (9.6, -8.8, 1.6)
    found = painter.find('--point', [add(place, ZERO)], '--k', '1500')
    painter.picture('query_point', painter.inside((5, -13, -0.5), (16, -4, 3)), found, [ball(place, 0.15)],
                    (7.5, -18, 5), (10.7, -8.6, 0.4), 32)


def main(program, site, folder, *names):
    with tempfile.TemporaryDirectory() as scratch:
        painter = Painter(program, site, folder, scratch)
        for paint in (query_rays, query_first_hit, query_cone, query_path, query_slab, query_frustum, query_box, query_point):
            if not names or paint.__name__.removeprefix('query_') in names:
                paint(painter)


main(*sys.argv[1:])
