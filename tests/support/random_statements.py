#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""random_statements.py rows|sums COUNT: statements of the paper's kind over 20,000 points of the courtyard, the same on every run.

Each is SQL that every engine understands that has dist_ray and dist_plane. `sums` have one row: count, sum of ids, least x, greatest
z. One statement per line, with a semicolon."""

import random
import sys

LEAST, GREATEST = (689941.0, 5324946.2, 598.6), (690059.0, 5325051.8, 613.7)
SIZE = 159.0

numbers = random.Random("paper")


def length(share):
    return f"{SIZE * share * numbers.random():.{numbers.choice([1, 4])}f}"


def distance(name):
    point = [f"{numbers.uniform(low, high):.{numbers.choice([0, 3])}f}" for low, high in zip(LEAST, GREATEST)]
    direction = numbers.choice(["0,0,-1", "1,0,0", "1,1,0", ",".join(f"{numbers.uniform(-1, 1)!r}" for _ in range(3))])
    return f"{name}({','.join(point)}, {direction}, x,y,z)"


def condition():
    return numbers.choice([
        lambda: f"{distance('dist_ray')} <= {length(0.1)}",
        lambda: f"{length(0.1)} > {distance('dist_ray')}",
        lambda: f"{distance('dist_ray')} BETWEEN {length(0.02)} AND {length(0.1)}",
        lambda: f"{distance('dist_plane')} BETWEEN -{length(0.05)} AND {length(0.05)}",
        lambda: f"abs({distance('dist_plane')}) < {length(0.05)}",
        lambda: f"NOT {distance('dist_ray')} >= {length(0.1)}",
    ])()


def statement(columns):
    first = condition()
    where = numbers.choice([
        lambda: first,
        lambda: f"{first} AND {condition()}",
        lambda: f"({first} OR {condition()})",
        lambda: f"{first} AND ({condition()} OR classification = 2)",
        lambda: f"classification > 1 AND {first} AND {distance('dist_plane')} >= 0",
    ])()
    return f"SELECT {columns} FROM points AS p WHERE {where};"


def main():
    form, count = sys.argv[1:]
    for _ in range(int(count)):
        print(statement("count(*) AS n, sum(id) AS ids, min(x) AS low, max(z) AS high" if form == "sums" else
                        f"p.id, z, classification, {distance('dist_ray')} AS d"))


main()
