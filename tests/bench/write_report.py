#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""write_report.py RESULTS REPOSITORY: fills tests/bench/page.md with what run_benchmarks.py measured.

Everything in docs/reports/benchmarks.md from the line "## Ray queries" on is replaced; what is above is measured by
hand and kept. Plots go to docs/images/bench_*.svg; without matplotlib they stay as they are, and that is said."""

import argparse
import datetime
import re
import subprocess
import sys
from pathlib import Path

import laz_tables
import query_tables
import ray_tables
import sql_tables
from bench_results import Results

FIRST_LINE = "## Ray queries"
PEERS = {"Embree": "libembree-dev", "nanoflann": "libnanoflann-dev", "Boost": "libboost-dev", "PCL": "libpcl-dev"}


def output_of(*command):
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def processor():
    found = re.search(r"model name\s*:\s*(.*)", Path("/proc/cpuinfo").read_text())
    return found.group(1) if found else "unknown processor"


def memory():
    kilobytes = int(re.search(r"MemTotal:\s*(\d+)", Path("/proc/meminfo").read_text()).group(1))
    return f"{kilobytes / 1e6:.0f} GB"


def system():
    found = re.search(r'PRETTY_NAME="(.*)"', Path("/etc/os-release").read_text())
    return found.group(1) if found else "Linux"


def peers():
    versions = [(name, output_of("dpkg-query", "-W", "-f", "${Version}", package)) for name, package in PEERS.items()]
    return ", ".join(f"{name} {version.split('+')[0]}" for name, version in versions if version) or "none installed"


def machine(results):
    cores = len(re.findall("^processor", Path("/proc/cpuinfo").read_text(), re.MULTILINE))
    load = results.largest_foreign_load()
    quiet = "nothing else ran" if load < 0.1 else f"**other programs kept up to {load:.1f} cores busy meanwhile**"
    return (f"Measured on {datetime.date.today()} on {cores} cores of {processor()}, {memory()}, {system()}, "
            f"{output_of('c++', '--version').splitlines()[0]}; {quiet}. Other libraries: {peers()}.")


def draw(results, images):
    try:
        import plots
    except ImportError:
        print("bench: matplotlib is not installed: plots are left as they are", file=sys.stderr)
        return
    images.mkdir(exist_ok=True)
    plots.rays(results, images / "bench_rays.svg")
    plots.builds(results, images / "bench_builds.svg")
    plots.figure_5(results, images / "bench_figure_5.svg")


def arguments():
    title, _, more = __doc__.partition("\n")
    parser = argparse.ArgumentParser(description=title.partition(": ")[2], epilog=more)
    parser.add_argument("results", type=Path, help="folder that run_benchmarks.py filled")
    parser.add_argument("repository", type=Path, help="its top folder")
    given = parser.parse_args()
    if not (given.results / "runs.json").is_file():
        parser.error(f"{given.results}: holds no runs.json; run_benchmarks.py writes it")
    if not (given.repository / "tests/bench/page.md").is_file():
        parser.error(f"{given.repository}: is not the top folder of the repository: it has no tests/bench/page.md")
    return given.results, given.repository


def main():
    folder, repository = arguments()
    results = Results(folder)
    parts = {
        "machine": machine(results),
        "closest": ray_tables.rays_table(results, "closest"),
        "occluded": ray_tables.rays_table(results, "occluded"),
        "threads": ray_tables.threads_table(results),
        "instruction_sets": ray_tables.instruction_sets_table(results),
        "instructions": ray_tables.instructions_table(results),
        "python": ray_tables.python_table(results),
        "builds": ray_tables.build_table(results),
        "table_1": query_tables.table_1(results),
        "large_box": query_tables.mean_found(results, "box_count_large", 10**5),
        "small_box": query_tables.mean_found(results, "box_count_small", 10**5),
        "points": query_tables.points_table(results),
        "all_nearest": query_tables.all_nearest_table(results),
        "site": query_tables.site_table(results),
        "figure_5": query_tables.figure_5_table(results),
        "identical": query_tables.identical_table(results),
        "laz": laz_tables.codec_table(results),
        "laz_files": laz_tables.files_table(results),
        "sql_load": sql_tables.load_table(results),
        "sql": sql_tables.queries_table(results),
    }
    template = (repository / "tests/bench/page.md").read_text()
    page = re.sub(r"\{(\w+)\}", lambda match: parts[match.group(1)], template)
    document = repository / "docs/reports/benchmarks.md"
    by_hand = document.read_text().split(FIRST_LINE)[0]
    document.write_text(by_hand + page)
    draw(results, repository / "docs/images")
    print(f"bench: wrote {document}")


if __name__ == "__main__":
    main()
