#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""run_benchmarks.py BUILD RESULTS [--full|--paper]: runs all benchmarks that fit this machine and keeps what they print.

Each size is a process of its own; its repetitions are interleaved. Beside Google Benchmark's JSON stands in runs.json
how much other programs worked meanwhile. --full adds 50 and 100 million points; --paper is for what the paper measured alone."""

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

# Embree's scene, both indexes and the cloud; builds need less.
BYTES_PER_POINT_OF_RAYS = 130
BYTES_PER_POINT_OF_UNIFORM = 60
BYTES_PER_POINT_OF_POINTS = 800


def available_memory():
    with open("/proc/meminfo") as lines:
        for line in lines:
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    return 0


def busy_seconds():
    """Processor time of the whole machine."""
    with open("/proc/stat") as lines:
        user, nice, system, _idle, _wait, irq, soft = map(int, lines.readline().split()[1:8])
    return (user + nice + system + irq + soft) / os.sysconf("SC_CLK_TCK")


def paper_runs():
    """As all_runs()."""
    for n in [10**6, 10**7, 10**8]:
        yield f"uniform_{n}", "octree_bench", f"^uniform/.*/{n}/", 3, n * BYTES_PER_POINT_OF_UNIFORM
    yield "points_100000", "point_bench", "^points/.*/100000/", 15, 10**5 * BYTES_PER_POINT_OF_POINTS


def all_runs(full):
    """(name, program, filter, repetitions, bytes) of every run."""
    sizes = [10**6, 10**7] + ([5 * 10**7, 10**8] if full else [])
    for n in sizes:
        few = n > 10**7
        yield f"builds_{n}", "octree_bench", f"^build/.*/{n}/", 3 if few else 5, n * BYTES_PER_POINT_OF_RAYS
        # Embree on two threads is compared for closest hits only.
        rays = f"^((embree/)?closest/.*|occluded/.*|embree/occluded/[^/]+/(single|packet8|packet16|stream))/{n}/"
        yield f"rays_{n}", "octree_bench", rays, 5, n * BYTES_PER_POINT_OF_RAYS
    million = 10**6 * BYTES_PER_POINT_OF_RAYS
    yield "instruction_sets", "octree_bench", "^instruction_set/[^/]+/(closest|occluded)/[PS]/[^/]+/1000000/", 5, million
    yield "instructions", "octree_bench", "^(embree/)?instructions/(closest|occluded)/(P|S|A_sun|A_vis)/", 1, million
    yield "site", "octree_bench", "^site/.*/1000000/", 5, million
    yield "identical", "octree_bench", "^identical/", 5, million
    for n in [10**6, 10**7] + ([10**8] if full else []):
        yield f"uniform_{n}", "octree_bench", f"^uniform/.*/{n}/", 5, n * BYTES_PER_POINT_OF_UNIFORM
    for n in [10**5, 10**6, 10**7]:
        yield f"points_{n}", "point_bench", f"^points/.*/{n}/", 15 if n == 10**5 else 5, n * BYTES_PER_POINT_OF_POINTS
    for n in [10**6, 10**7]:
        yield f"python_{n}", "python_bench", f"^python/.*/{n}/", 9, 10**9 + n * BYTES_PER_POINT_OF_UNIFORM
    yield "laz", "laz_bench", ".", 5, 10**9
    yield "sql", "database_bench", ".", 5, 2 * 10**9


def run(program, results, name, pattern, repetitions):
    """Returns the average number of cores that other programs kept busy, and the seconds it took."""
    before, begin = busy_seconds(), time.time()
    own_before = os.times()
    done = subprocess.run(
        [program, f"--benchmark_filter={pattern}", f"--benchmark_repetitions={repetitions}",
         "--benchmark_enable_random_interleaving=true", f"--benchmark_out={results / name}.json",
         "--benchmark_out_format=json"],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"bench: {program} failed:\n{done.stderr}")
    seconds = time.time() - begin
    own = os.times()
    own_seconds = own.children_user + own.children_system - own_before.children_user - own_before.children_system
    return max(0.0, busy_seconds() - before - own_seconds) / seconds, seconds


def arguments():
    title, _, more = __doc__.partition("\n")
    parser = argparse.ArgumentParser(description=title.partition(": ")[2], epilog=more)
    parser.add_argument("build", type=Path, help="build folder, configured with ALIDADE_BUILD_BENCHMARKS=ON")
    parser.add_argument("results", type=Path, help="folder for the figures; those of an earlier run are removed")
    parser.add_argument("--full", action="store_true", help="also 50 and 100 million points")
    parser.add_argument("--paper", action="store_true", help="only what the paper measured: points, and random rays")
    given = parser.parse_args()
    runs = list(paper_runs() if given.paper else all_runs(given.full))
    for program in sorted({run[1] for run in runs}):
        if not (given.build / "tests/bench" / program).is_file():
            parser.error(f"{given.build}: has no tests/bench/{program}")
    return given.build, given.results, runs


def main():
    build, results, wanted = arguments()
    results.mkdir(parents=True, exist_ok=True)
    for old in results.glob("*.json"):
        old.unlink()
    runs = {}
    for name, program, pattern, repetitions, needed in wanted:
        if needed > available_memory():
            print(f"bench: {name} is left out: it needs {needed / 1e9:.0f} GB of free memory", flush=True)
            continue
        print(f"bench: {name} ... ", end="", flush=True)
        foreign, seconds = run(build / "tests" / "bench" / program, results, name, pattern, repetitions)
        runs[name] = {"foreign_cores": round(foreign, 2), "seconds": round(seconds, 1)}
        print(f"{seconds:.0f} s, other programs on {foreign:.2f} cores", flush=True)
        (results / "runs.json").write_text(json.dumps(runs, indent=1))


main()
