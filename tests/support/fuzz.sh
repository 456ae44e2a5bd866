#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# fuzz.sh BUILD_FOLDER SECONDS: runs every fuzz target of the build for so long, as many at a time as there are cores.
# Inputs found are kept in BUILD_FOLDER/corpus; what breaks a target is left in BUILD_FOLDER/findings and named.
set -euo pipefail
build=$(readlink -f -- "$1")
seconds=$2
cd -- "$(dirname -- "$0")/../.."
mkdir -p "$build/findings" "$build/logs"

run_target() {
  local target=$1 name corpus seeds=()
  name=$(basename -- "$target")
  corpus=$build/corpus/$name
  mkdir -p "$corpus"
  if [[ -d tests/fuzz/seeds/$name ]]; then seeds=("tests/fuzz/seeds/$name"); fi
  if "$target" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=1024 -max_len=262144 \
    -artifact_prefix="$build/findings/$name-" -print_final_stats=1 "$corpus" "${seeds[@]}" >"$build/logs/$name.log" 2>&1; then
    echo "$name: $(sed -n 's/^stat::number_of_executed_units: *//p' "$build/logs/$name.log") inputs, nothing found"
  else
    tail -n 60 "$build/logs/$name.log"
    echo "$name: FAILED, the input is beside $build/findings/$name-"
    return 1
  fi
}
export -f run_target
export build seconds

mapfile -t targets < <(find "$build/tests/fuzz" -maxdepth 1 -type f -executable | sort)
if ((${#targets[@]} == 0)); then
  echo "no fuzz targets in $build/tests/fuzz" >&2
  exit 1
fi
printf '%s\0' "${targets[@]}" | xargs -0 --max-procs "$(nproc)" --max-args 1 bash -c 'run_target "$0"'
