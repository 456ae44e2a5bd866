# SPDX-License-Identifier: MIT
# Steps of `./dev test`: each is run to its end, timed and remembered; a failed one does not keep the others from running.

step_rows=()
failed_steps=0
left_out=0
step_logs=$(mktemp -d)
trap 'rm -rf -- "$step_logs"' EXIT
# How compilers, tests and sanitizers mark what went wrong.
step_trouble='Failure$|runtime error:|Sanitizer:|error:|\*\*\*(Failed|Timeout|Exception|Not Run)|FAILED'

# step NAME COMMAND...
step() {
  local name=$1 status start=$SECONDS
  shift
  printf '\n==== %s\n' "$name"
  # A subshell in no condition, so that its `set -e` counts.
  set +e
  (
    set -e
    "$@"
  ) 2>&1 | tee "$step_logs/step"
  status=${PIPESTATUS[0]}
  set -e
  local result=passed
  if ((status != 0)); then
    result=FAILED
    failed_steps=$((failed_steps + 1))
    mv "$step_logs/step" "$step_logs/failed $failed_steps, $name"
  fi
  step_rows+=("$(printf '%-36s %-7s %6d s' "$name" "$result" $((SECONDS - start)))")
  printf -- '---- %s: %s\n' "$name" "$result"
}

# step_before SECONDS NAME COMMAND...: a step, or a line that it is left out if the script has run for that many seconds.
step_before() {
  local limit=$1
  shift
  if ((SECONDS < limit)); then
    step "$@"
    return
  fi
  left_out=$((left_out + 1))
  step_rows+=("$(printf '%-36s left out' "$1")")
  printf -- '\n---- %s: left out after %d s, see ./dev nightly\n' "$1" "$SECONDS"
}

# What failed steps said, once more: whoever sees only the end of a long output still learns what broke.
tell_failures() {
  local log
  for log in "$step_logs"/failed*; do
    printf '\n==== from what %s said\n' "${log#*, }"
    { grep -E -A 12 "$step_trouble" "$log" || true; } | head -n 150
    printf -- '---- its last lines\n'
    tail -n 15 "$log"
  done
}

# summary: the table and the closing line; fails if a step did.
summary() {
  if ((failed_steps > 0)); then tell_failures; fi
  printf '\n%-36s %-7s %8s\n' step result time
  printf '%s\n' "${step_rows[@]}"
  if ((failed_steps > 0)); then
    printf '\n%d of %d steps FAILED in %d s\n' "$failed_steps" "${#step_rows[@]}" "$SECONDS"
    return 1
  fi
  if ((left_out > 0)); then
    printf '\n%d steps passed in %d s, %d left out\n' "$((${#step_rows[@]} - left_out))" "$SECONDS" "$left_out"
    return
  fi
  printf '\nall %d steps passed in %d s\n' "${#step_rows[@]}" "$SECONDS"
}
