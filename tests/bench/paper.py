#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""paper.py BUILD RESULTS REPOSITORY: repeats the experiments of the paper and writes docs/reports/paper.md.

Clouds, databases and pictures are made in RESULTS, and kept for the next run. Other engines come from npm; without Node their
table is left as a note. Needs 9 GB of disk for the cloud of the picture."""

import argparse
import json
import re
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path

import query_tables
from bench_results import Results
from ray_tables import number, table
from write_report import machine

REPETITIONS = 5
PICTURE_POINTS = 10**8
SQL_QUESTIONS = [("ray along the ground, r = 1 m", "dist_ray(690000,5325000,601.5, 1,0.2,0, x,y,z) <= 1"),
                 ("diagonal ray, r = 1 m", "dist_ray(690000,5325000,601.5, 1,1,0, x,y,z) <= 1"),
                 ("plumb line, r = 1 m", "dist_ray(690010,5325010,640, 0,0,-1, x,y,z) <= 1"),
                 ("oblique slab of 0.1 m", "dist_plane(690000,5325000,600, 1,0.3,0.1, x,y,z) BETWEEN 0 AND 0.1")]


class Run:
    def __init__(self, build, results, repository):
        self.program, self.build, self.results, self.repository = build / "alidade", build, results, repository

    def make(self, name, *words):
        """The file of this name in the results, made by `alidade WORDS -o FILE` if it is not there."""
        path = self.results / name
        if not path.exists():
            print(f"paper: making {name}", flush=True)
            part = self.results / f"part_{name}"
            part.unlink(missing_ok=True)
            output = [part] if words[0] == "sql" else ["-o", part]
            subprocess.run([self.program, *words, *output, "-q"], check=True)
            part.rename(path)
        return path

    def milliseconds_in_sql(self, database, statement):
        """(rows, milliseconds, percent of chunks that were read): those that `alidade sql --explain` prints, medians."""
        found = []
        for _ in range(REPETITIONS):
            told = subprocess.run([self.program, "sql", database, statement, "--csv", "--explain"], check=True,
                                  capture_output=True, text=True)
            share = re.search(r"chunks \(([\d.]+) %\)", told.stderr)
            spent = re.search(r"([\d.]+) ms", told.stderr)
            found.append((int(told.stdout.split()[1]), float(spent.group(1)), float(share.group(1))))
        return found[0][0], statistics.median(ms for _, ms, _ in found), found[0][2]


def sql_table(run, cloud):
    places = [("SQLite, loaded", run.make("site.db", "sql", "load", cloud)),
              ("SQLite, index file in place", run.make("site.alidade", "index", cloud))]
    rows = []
    for name, condition in SQL_QUESTIONS:
        for place, path in places:
            count, spent, share = run.milliseconds_in_sql(path, f"SELECT count(*) FROM points WHERE {condition}")
            # A condition behind + 0 has no limit that prunes.
            _, plain, _ = run.milliseconds_in_sql(path, "SELECT count(*) FROM points WHERE " +
                                                  re.sub(r"\) (<=|BETWEEN)", r") + 0 \1", condition))
            rows.append([name, place, str(count), number(share), number(spent), number(plain)])
    return table(["condition", "engine", "rows", "chunks read, %", "ms", "ms without pruning"], rows)


def engines_table(run, cloud):
    if shutil.which("npm") is None:
        return "Not measured: Node is not installed."
    readers = run.results / "readers"
    readers.mkdir(exist_ok=True)
    modules = run.repository / "extensions/parquet/tests/readers"
    for file in [*modules.glob("*.mjs"), modules / "package.json", run.repository / "tests/bench/engines.mjs"]:
        shutil.copy(file, readers)
    installed = subprocess.run(["npm", "install", "--no-audit", "--no-fund", "--no-package-lock"], cwd=readers,
                               capture_output=True, text=True)
    if installed.returncode != 0:
        return "Not measured: npm could not install the engines."
    parquet = run.make("site.parquet", "convert", cloud)
    told = subprocess.run(["node", readers / "engines.mjs", run.program, cloud, parquet, str(REPETITIONS)], check=True,
                          capture_output=True, text=True)
    found = json.loads(told.stdout.splitlines()[-1])
    rows = []
    for answer in found["answers"]:
        duckdb, fusion = answer["duckdb"], answer["datafusion"]
        if len({form["rows"] for engine in (duckdb, fusion) for form in engine.values()}) != 1:
            sys.exit(f"paper: the engines have different answers: {answer}")
        rows.append([answer["name"], str(duckdb["plain"]["rows"]),
                     number(100 * duckdb["pruned"]["emitted"] / found["points"]), number(duckdb["pruned"]["ms"]),
                     number(duckdb["plain"]["ms"]), number(fusion["pruned"]["bytes"] / 1e6),
                     number(fusion["plain"]["bytes"] / 1e6), f"{fusion['pruned']['groups']} of {found['groups']}",
                     number(fusion["pruned"]["ms"]), number(fusion["plain"]["ms"])])
    return table(["condition", "rows", "DuckDB: rows tested, %", "ms", "ms, plain", "DataFusion: MB read", "MB, plain",
                  "row groups read", "ms", "ms, plain"], rows)


def picture(run):
    index = run.results / "picture.alidade"
    if not index.exists():
        cloud = run.make("picture.las", "generate", "courtyard", "--points", str(PICTURE_POINTS), "--seed", "1")
        run.make("picture.alidade", "index", cloud)
        cloud.unlink()
    camera = run.repository / "scenes/courtyard.camera.json"
    words = [run.program, "render", index, "--camera", camera, "--size", "600x400", "--samples", "50", "--normals", "sphere",
             "-o", run.results / "picture.png", "--overwrite", "-q"]
    times = []
    for _ in range(3):
        begin = time.monotonic()
        subprocess.run(words, check=True)
        times.append(time.monotonic() - begin)
    return number(statistics.median(times))


def draw_figure_5(results, path):
    try:
        import plots
    except ImportError:
        print("paper: matplotlib is not installed: the plot is left as it is", file=sys.stderr)
        return
    plots.figure_5(results, path)


def arguments():
    title, _, more = __doc__.partition("\n")
    parser = argparse.ArgumentParser(description=title.partition(": ")[2], epilog=more)
    parser.add_argument("build", type=Path, help="build folder, configured with ALIDADE_BUILD_BENCHMARKS=ON")
    parser.add_argument("results", type=Path, help="folder for figures and clouds")
    parser.add_argument("repository", type=Path, help="its top folder")
    given = parser.parse_args()
    if not (given.build / "alidade").is_file():
        parser.error(f"{given.build}: has no program alidade")
    return Run(given.build.resolve(), given.results.resolve(), given.repository.resolve())


def main():
    run = arguments()
    run.results.mkdir(parents=True, exist_ok=True)
    bench = run.repository / "tests/bench/run_benchmarks.py"
    subprocess.run([sys.executable, bench, run.build, run.results / "bench", "--paper"], check=True)
    results = Results(run.results / "bench")
    cloud = run.make("site.laz", "generate", "courtyard", "--points", "1e7", "--seed", "1")
    parts = {
        "machine": machine(results),
        "table_1": query_tables.table_1(results),
        "figure_5": query_tables.figure_5_table(results),
        "sql": sql_table(run, cloud),
        "engines": engines_table(run, cloud),
        "picture_points": f"{PICTURE_POINTS // 10**6} million",
        "picture": picture(run),
    }
    template = (run.repository / "tests/bench/paper.md").read_text()
    page = re.sub(r"\{(\w+)\}", lambda match: parts[match.group(1)], template)
    (run.repository / "docs/reports/paper.md").write_text(page)
    draw_figure_5(results, run.repository / "docs/images/bench_figure_5.svg")
    print("paper: wrote docs/reports/paper.md")


if __name__ == "__main__":
    main()
