#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# run.sh BUILD [BENCHMARK OPTION...]: runs the benchmarks of a build folder, interleaved, and prints medians.
# Without options: one million points, five repetitions. docs/benchmarks.md names the commands behind its figures.
set -euo pipefail
build=$1
shift
if [[ $# -eq 0 ]]; then
  set -- --benchmark_filter=/1000000/ --benchmark_repetitions=5
fi
"$build/tests/bench/octree_bench" --benchmark_enable_random_interleaving=true \
  --benchmark_report_aggregates_only=true --benchmark_counters_tabular=true "$@"
