# SPDX-License-Identifier: MIT
"""Random rays and planes, asked through BRIN, through GiST and of a plain table, and worked out here in Python.

random_rays.py CONNECTION: exits with 1 if an answer differs by a row.
"""
import math
import random
import subprocess
import sys

RAYS = 100


def unit(v):
    largest = max(map(abs, v))
    scaled = [c / largest for c in v]
    length = math.sqrt(scaled[0] * scaled[0] + scaled[1] * scaled[1] + scaled[2] * scaled[2])
    return [c / length for c in scaled]


def dist_ray(place, direction, point):
    d = unit(direction)
    x, y, z = (p - o for p, o in zip(point, place))
    cross = y * d[2] - z * d[1], z * d[0] - x * d[2], x * d[1] - y * d[0]
    return math.sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2])


def dist_plane(place, normal, point):
    n = unit(normal)
    x, y, z = (p - o for p, o in zip(point, place))
    return x * n[0] + y * n[1] + z * n[2]


class Cases:
    def __init__(self, seed):
        self.random = random.Random(seed)
        self.centre = (690000.0, 5325000.0, 400.0)

    def point(self):
        """Half on undulating ground, half on walls."""
        r = self.random
        x, y = r.uniform(0, 200), r.uniform(0, 200)
        if r.random() < 0.5:
            place = (x, y, 2 * math.sin(x / 20) + math.cos(y / 15))
        else:
            place = (round(x / 40) * 40.0, y, r.uniform(0, 15)) if r.random() < 0.5 else (x, round(y / 40) * 40.0, r.uniform(0, 15))
        return tuple(round(c + p, 3) for c, p in zip(self.centre, place))

    def direction(self):
        r = self.random
        kind = r.randrange(5)
        if kind == 0:  # along an axis
            axis = r.randrange(3)
            return tuple(r.choice((1.0, -1.0)) if i == axis else r.choice((0.0, -0.0)) for i in range(3))
        length = 1e-200 if kind == 1 else 1.0
        direction = [length * r.gauss(0, 1) for _ in range(3)]
        if kind == 2:  # in an axis plane
            direction[r.randrange(3)] = 0.0
        if kind == 3:  # nearly along an axis
            direction = [1e-9 * c for c in direction]
            direction[r.randrange(3)] = 1.0
        return tuple(direction)

    def question(self, points):
        """A condition as the parts of SQL and as what it means."""
        r = self.random
        name, distance = r.choice((("dist_ray", dist_ray), ("dist_ray", dist_ray), ("dist_plane", dist_plane)))
        direction = self.direction()
        back = r.choice((0.0, 1e6, r.uniform(-200, 200)))
        place = tuple(c - back * d for c, d in zip(r.choice(points), unit(direction)))
        # Half of the limits are the distance of a point, so that the last bit decides.
        bound = distance(place, direction, r.choice(points)) if r.random() < 0.5 else r.uniform(0, 5)
        symbol, keeps = r.choice((("<=", lambda d: d <= bound), ("<", lambda d: d < bound), (">=", lambda d: d >= bound),
                                  (">", lambda d: d > bound), ("=", lambda d: d == bound)))
        numbers = ",".join(map(repr, place + direction))
        call = f"{name}({numbers}, x,y,z)"
        return call, f"{call} {symbol} {bound!r}", [distance(place, direction, p) for p in points], keeps


def psql(connection, script):
    run = subprocess.run(["psql", "-X", "-q", "-A", "-t", "-v", "ON_ERROR_STOP=1", connection], input=script, text=True, capture_output=True)
    if run.returncode != 0:
        sys.exit(f"psql: {run.stderr}")
    return run.stdout.splitlines()


def main(connection):
    cases = Cases(20261123)
    points = [cases.point() for _ in range(8000)]
    rows = {"first": range(0, 6000), "later": range(6000, 8000)}

    def copied(part):
        return "".join(f"{i}\t" + "\t".join(map(repr, points[i])) + "\n" for i in rows[part]) + "\\.\n"

    script = ["CREATE EXTENSION alidade_pg;"]
    for table in ("plain", "brin", "gist"):
        script.append(f"CREATE TABLE {table}(id int, x float8, y float8, z float8);\n"
                      f"CREATE TEMP TABLE staging_{table}(LIKE {table});\nCOPY staging_{table} FROM stdin;\n{copied('first')}"
                      f"INSERT INTO {table} SELECT * FROM staging_{table} ORDER BY cloud_point(x,y,z);")
    script.append("CREATE INDEX ON brin USING brin (cloud_point(x,y,z)) WITH (pages_per_range = 1);"
                  "CREATE INDEX ON gist USING gist (cloud_point(x,y,z)); ANALYZE; SET enable_seqscan = off;")
    wrong = asked = matches = pages = 0
    for part in ("first", "later"):
        if part == "later":
            for table in ("plain", "brin", "gist"):
                script.append(f"COPY {table} FROM stdin;\n{copied(part)}")
        present = points[:rows[part].stop]
        expected = []
        for _ in range(RAYS):
            call, condition, distances, keeps = cases.question(present)
            ids = [i for i, d in enumerate(distances) if keeps(d)]
            matches += len(ids)
            nearest = sorted(distances)[:10]
            for table in ("plain", "brin", "gist"):
                script.append(f"SELECT coalesce(string_agg(id::text, ',' ORDER BY id), '') FROM {table} WHERE {condition};")
                expected.append((f"{table}: {condition}", ",".join(map(str, ids))))
            # The plan, to see that the indexes were asked.
            for table in ("brin", "gist"):
                script.append(f"EXPLAIN (COSTS OFF) SELECT * FROM {table} WHERE {condition};")
                expected.append((f"{table}: plan of {condition}", None))
            script.append(f"SELECT string_agg(d::text, ',') FROM (SELECT {call} AS d FROM gist ORDER BY {call} LIMIT 10) n;")
            expected.append((f"nearest: {call}", nearest))
        answers = psql(connection, "\n".join(script))
        script = ["SET enable_seqscan = off;"]
        place = 0
        for question, right in expected:
            asked += 1
            if right is None:
                plan = []
                while place < len(answers) and (not plan or "Cond" in answers[place] or "->" in answers[place]):
                    plan.append(answers[place])
                    place += 1
                ok, answer = any("Index Cond" in line for line in plan), plan
            else:
                answer = answers[place]
                place += 1
                ok = answer == right if isinstance(right, str) else [float(d) for d in answer.split(",")] == right
            if not ok:
                wrong += 1
                print(f"{question}\n  expected {str(right)[:200]}\n  found    {str(answer)[:200]}")
    print(f"{asked} answers, {matches} matches, {wrong} wrong")
    return 0 if wrong == 0 and matches > 10 * RAYS else 1


sys.exit(main(sys.argv[1]))
