#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Every command on degenerate clouds: how long it takes beside a cloud of random points, and how soon it stops.

degenerate.py ALIDADE FOLDER [--points 100000] [--stop-points 400000] [--only TEXT] [--clouds equal,zeros]

Prints two tables in Markdown. The first has seconds of processor time, and ends with exit code 1 if a command takes more than
10 times as long as on the random cloud, which counts for one second at least. The second has the longest time from SIGINT or SIGTERM,
sent at several moments, to the end of the program; more than one second is wrong, too."""

import argparse
import os
import pathlib
import random
import signal
import subprocess
import sys
import time

MOST_TIMES, LEAST_SECONDS, MOST_SECONDS_TO_STOP = 10.0, 1.0, 1.0
LONGEST = 600.0  # seconds, after which a run has failed


def random_points(count):
    """An undulating ground with points above it, some 20 m wide."""
    draw = random.Random(7)
    for _ in range(count):
        x, y = draw.uniform(-10, 10), draw.uniform(-10, 10)
        yield x, y, 0.02 * x * y + (draw.uniform(0, 5) if draw.random() < 0.2 else 0)


def half_zeros(count, offset):
    for i, (x, y, z) in enumerate(random_points(count)):
        yield (0, 0, 0) if i % 2 else (x + offset[0], y + offset[1], z + offset[2])


CLOUDS = {
    "random": random_points,
    "equal": lambda count: ((1, 2, 3) for _ in range(count)),
    "two": lambda count: ((1 + i % 2, 2, 3) for i in range(count)),
    "line": lambda count: ((i * 20 / count, i * 10 / count, i * 2 / count) for i in range(count)),
    "row": lambda count: ((i * 20 / count, 0, 0) for i in range(count)),
    "zeros": lambda count: half_zeros(count, (0, 0, 1.7)),
    "far_zeros": lambda count: half_zeros(count, (690000, 5325000, 600)),
}

# Where the observer stands: over the points, beside them where they are few, and in the scanner, which is among the zeros.
EYES = {"random": (1, 2, 3), "equal": (1.5, 2, 4), "two": (1.5, 2, 4), "line": (5, 5, 3), "row": (5, 1, 2), "zeros": (0, 0, 0),
        "far_zeros": (690001, 5325002, 603)}


def write_inputs(folder, name, points):
    """The cloud, targets on all its points, cameras and positions."""
    points = list(points)
    eye = EYES[name]
    text = {"cloud.xyz": "".join("%.4f %.4f %.4f\n" % point for point in points)}
    text["points.csv"] = "x,y,z\n" + "".join("%.4f,%.4f,%.4f\n" % point for point in points)
    text["rays.csv"] = "ox,oy,oz,dx,dy,dz\n" + "".join("%.4f,%.4f,%.4f,0.1,0,-1\n" % (x - 1, y, z + 10) for x, y, z in points)
    text["cones.csv"] = "ox,oy,oz,dx,dy,dz,half_angle\n" + "".join("%.4f,%.4f,%.4f,0,0,-1,1\n" % (x, y, z + 5) for x, y, z in points)
    text["boxes.csv"] = "min_x,min_y,min_z,max_x,max_y,max_z\n" + "".join(
        ",".join("%.4f" % (at + side) for side in (-0.05, 0.05) for at in point) + "\n" for point in points)
    low, high = (tuple(pick(point[axis] for point in points) for axis in range(3)) for pick in (min, max))
    text["path.csv"] = "x,y,z\n%s,%s,%s\n%s,%s,%s\n" % (*(at - 1 for at in low), *(at + 1 for at in high))
    text["planes.csv"] = "px,py,pz,nx,ny,nz\n%s,%s,%s,0,0.1,1\n" % points[len(points) // 2]
    text["places.csv"] = "name,x,y,z\n" + "".join(
        "p%d,%s,%s,%s\n" % (i, eye[0] + 0.5 * i, eye[1] - 0.3 * i, eye[2] + 0.1 * i) for i in range(8))
    (folder / "sparse").mkdir(parents=True)
    text["sparse/cameras.txt"] = "1 PINHOLE 320 240 240 240 160 120\n"
    # Looks along x, from beside the points.
    text["sparse/images.txt"] = "1 0.5 0.5 -0.5 0.5 %s %s %s 1 a.jpg\n\n" % (eye[1], eye[2], -(eye[0] - 3))
    text["sparse/points3D.txt"] = ""
    for file, content in text.items():
        (folder / file).write_text(content, encoding="utf-8")


def commands(eye):
    """Words of every command by its name; what they write begins with out."""
    observer = "--observer=%s,%s,%s" % eye
    see = ("visibility", "points", "cloud.las", observer)
    ray = ",".join(str(at) for at in eye) + ",1,0.5,-0.2"
    return {
        "info --stats": ("info", "--stats", "cloud.las"),
        "convert --spacing": ("convert", "cloud.las", "-o", "out.laz", "--spacing", "0.02"),
        "convert --normals": ("convert", "cloud.las", "-o", "out.ply", "--normals"),
        "convert copc": ("convert", "cloud.las", "-o", "out.copc.laz"),
        "convert parquet": ("convert", "cloud.las", "-o", "out.parquet"),
        "index --spacings": ("index", "cloud.las", "-o", "out.alidade", "--spacings", "8"),
        "index --surfaces": ("index", "cloud.las", "-o", "out.alidade", "--surfaces"),
        "index layered": ("index", "cloud.las", "-o", "out.alidade", "--organisation", "layered"),
        "query --points": ("query", "cloud.las", "--points", "points.csv", "--k", "8", "-o", "out.csv"),
        "query --rays": ("query", "cloud.las", "--rays", "rays.csv", "--radius", "0.05", "--k", "1", "-o", "out.csv"),
        "query --rays distance": ("query", "cloud.las", "--rays", "rays.csv", "--measure", "distance", "--k", "4", "-o", "out.csv"),
        "query --rays --occluded": ("query", "cloud.las", "--rays", "rays.csv", "--radius", "0.05", "--occluded", "-o", "out.csv"),
        "query --cones": ("query", "cloud.las", "--cones", "cones.csv", "--k", "2", "-o", "out.csv"),
        "query --boxes": ("query", "cloud.las", "--boxes", "boxes.csv", "--count", "-o", "out.csv"),
        "query --path": ("query", "cloud.las", "--path", "path.csv", "--radius", "0.5", "-o", "out.csv"),
        "query --planes": ("query", "cloud.las", "--planes", "planes.csv", "-o", "out.csv"),
        "query --where": ("query", "cloud.las", "--points", "points.csv", "--k", "4", "--where", "intensity < 10 AND x > -1e9", "-o",
                          "out.csv"),
        "render sphere": ("render", "cloud.las", "-o", "out.png", "--size", "320x240", "--samples", "4", "--surface", "sphere"),
        "render disc": ("render", "cloud.las", "-o", "out.png", "--size", "320x240", "--samples", "4", "--surface", "disc"),
        "render blend": ("render", "cloud.las", "-o", "out.png", "--size", "320x240", "--samples", "4", "--surface", "blend"),
        "render panorama": ("render", "cloud.las", "-o", "out.png", "--size", "320x160", "--samples", "4", "--panorama=%s,%s,%s" % eye),
        "render --depth": ("render", "cloud.las", "--depth", "out.exr", "--size", "320x240"),
        "points": (*see, "-o", "out.las"),
        "points --fraction": (*see, "--fraction", "8", "-o", "out.las"),
        "points --blockers": (*see, "--blockers", "all", "-o", "out.las"),
        "points --transparency": (*see, "--transparency", "3", "-o", "out.las"),
        "points --radius": (*see, "--radius", "0.05", "-o", "out.las"),
        "raster": ("visibility", "raster", "cloud.las", observer, "--resolution", "0.25", "-o", "out.tif"),
        "horizon": ("visibility", "horizon", "cloud.las", observer, "-o", "out.csv"),
        "lines": ("visibility", "lines", "cloud.las", "--places", "places.csv", "--frequency", "5.8GHz", "-o", "out.json"),
        "sky": ("visibility", "sky", "cloud.las", "-o", "out.las"),
        "sky map": ("visibility", "sky", "cloud.las", "--resolution", "0.25", "-o", "out.tif"),
        "sun": ("visibility", "sun", "cloud.las", "--place", "48.1,11.6", "--from", "2026-06-21", "-o", "out.las"),
        "sun --bounces": ("visibility", "sun", "cloud.las", "--place", "48.1,11.6", "--from", "2026-06-21", "--bounces", "1", "-o",
                          "out.las"),
        "place": ("visibility", "place", "cloud.las", "--observers", "places.csv", "--count", "3", "-o", "out.csv"),
        "summary": ("visibility", "summary", "cloud.las", "--observers", "places.csv", "-o", "out.csv"),
        "photos": ("visibility", "photos", "cloud.las", "--camera", "sparse", "-o", "out.las", "--footprints", "out.gpkg"),
        "change": ("change", "cloud.las", "cloud.las", "--origin-before=%s,%s,%s" % eye, "--origin-after=%s,%s,%s" % eye, "-o", "out.las"),
        "change --normal-radius": ("change", "cloud.las", "cloud.las", "--no-sight", "--normal-radius", "0.3", "--cylinder-radius", "0.2",
                                   "-o", "out.las"),
        "sql load": ("sql", "load", "cloud.las", "out.db"),
        "sql dist_ray": ("sql", "cloud.las", "SELECT id, dist FROM points(%s) ORDER BY dist LIMIT 1000" % ray, "--csv"),
        "sql join": ("sql", "cloud.las", "SELECT count(*) FROM points WHERE dist_ray(%s, x, y, z) < 1" % ray),
    }


def clear(folder):
    for path in folder.glob("out.*"):
        path.unlink()


class Run:
    """A run of the program: its seconds of processor time, its exit code and what it said."""

    def __init__(self, program, words, folder, signal_after=None, number=signal.SIGINT):
        clear(folder)
        begin, self.to_stop = time.monotonic(), None
        with open(folder / "said.txt", "wb") as said:
            process = subprocess.Popen([program, *words], cwd=folder, stdout=subprocess.DEVNULL, stderr=said)
            sent = None
            while True:
                pid, status, usage = os.wait4(process.pid, os.WNOHANG)
                now = time.monotonic()
                if pid != 0:
                    break
                if signal_after is not None and sent is None and now - begin >= signal_after:
                    process.send_signal(number)
                    sent = now
                if now - begin > LONGEST:
                    process.kill()
                time.sleep(0.002)
        process.returncode = 0  # it was waited for
        self.code = os.waitstatus_to_exitcode(status)
        self.seconds, self.wall = usage.ru_utime + usage.ru_stime, now - begin
        if sent is not None:
            self.to_stop = now - sent
        self.said = (folder / "said.txt").read_text(encoding="utf-8", errors="replace")
        self.left = sorted(path.name for path in folder.iterdir() if ".part-" in path.name)


def table(columns, rows):
    print("| " + " | ".join(columns) + " |\n|" + "---|" * len(columns))
    for row in rows:
        print("| " + " | ".join(row) + " |", flush=True)


def time_commands(program, folders, chosen):
    """The first table; whether all is well."""
    is_well, rows = True, []
    for name in chosen:
        row, usual = [name], None
        for cloud, folder in folders.items():
            run = Run(program, commands(EYES[cloud])[name], folder)
            if run.code not in (0, 1, 2):
                row.append("**exit %d after %.1f s**" % (run.code, run.seconds))
                is_well = False
                continue
            if usual is None:
                usual = max(run.seconds, LEAST_SECONDS)
            is_slow = run.seconds > MOST_TIMES * usual
            is_well = is_well and not is_slow
            text = "%.2f%s" % (run.seconds, "" if run.code == 0 else " (no)" if run.code == 1 else " (error)")
            row.append("**%s**" % text if is_slow else text)
            if run.code == 2:
                print(cloud, name, run.said.strip().splitlines()[-1:], file=sys.stderr)
        rows.append(row)
        print(" ".join(row), file=sys.stderr, flush=True)
    table(["command, seconds", *folders], rows)
    return is_well


def stop_commands(program, folders, chosen):
    """The second table; whether all is well."""
    is_well, rows = True, []
    for name in chosen:
        row = [name]
        for cloud, folder in folders.items():
            words = commands(EYES[cloud])[name]
            whole = Run(program, words, folder, LONGEST / 10).wall
            slowest, stops = 0.0, 0
            for number, share in ((signal.SIGINT, 0.15), (signal.SIGTERM, 0.3), (signal.SIGINT, 0.45), (signal.SIGTERM, 0.6),
                                  (signal.SIGINT, 0.75), (signal.SIGTERM, 0.9)):
                run = Run(program, words, folder, share * min(whole, 20.0), number)
                if run.to_stop is None:
                    continue  # it was done before
                slowest, stops = max(slowest, run.to_stop), stops + 1
                # Before the program handles signals they end it, at once.
                if run.code not in (0, 1, 130, -number) or run.left:
                    row.append("**exit %d** %s" % (run.code, run.left))
                    is_well = False
            is_slow = slowest > MOST_SECONDS_TO_STOP
            is_well = is_well and not is_slow
            text = "%.2f (of %.1f)" % (slowest, whole) if stops else "-"
            row.append("**%s**" % text if is_slow else text)
        rows.append(row)
        print(" ".join(row), file=sys.stderr, flush=True)
    table(["command, seconds to stop", *folders], rows)
    return is_well


def make_clouds(program, folder, names, count):
    folders = {}
    for name in names:
        own = folder / ("%s_%d" % (name, count))
        if not own.exists():
            write_inputs(own, name, CLOUDS[name](count))
            subprocess.run([program, "convert", "cloud.xyz", "-o", "cloud.las", "-q"], cwd=own, check=True)
        folders[name] = own
    return folders


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--points", type=int, default=100000, help="of the clouds of the first table; 0: leave it out")
    parser.add_argument("--stop-points", type=int, default=400000, help="of those of the second; 0: leave it out")
    parser.add_argument("--only", default="", help="commands with this text in their name")
    parser.add_argument("--clouds", default=",".join(CLOUDS), help="kinds of clouds, separated by commas")
    words = parser.parse_args()
    program = os.path.abspath(words.program)
    names = ["random"] + [name for name in words.clouds.split(",") if name != "random"]
    chosen = [name for name in commands(EYES["random"]) if words.only in name]
    is_well = True
    if words.points > 0:
        is_well = time_commands(program, make_clouds(program, words.folder, names, words.points), chosen)
    if words.stop_points > 0:
        stopped = [name for name in names if name in ("random", "zeros")]
        is_well = stop_commands(program, make_clouds(program, words.folder, stopped, words.stop_points), chosen) and is_well
    sys.exit(0 if is_well else 1)


if __name__ == "__main__":
    main()
