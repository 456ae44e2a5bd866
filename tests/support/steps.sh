# SPDX-License-Identifier: MIT
# Steps of `./dev test`: each is run to its end, timed and remembered; a failed one does not keep the others from running.

step_rows=()
failed_steps=0

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
  )
  status=$?
  set -e
  local result=passed
  if ((status != 0)); then
    result=FAILED
    failed_steps=$((failed_steps + 1))
  fi
  step_rows+=("$(printf '%-36s %-7s %6d s' "$name" "$result" $((SECONDS - start)))")
  printf -- '---- %s: %s\n' "$name" "$result"
}

# summary: the table and the closing line; fails if a step did.
summary() {
  printf '\n%-36s %-7s %8s\n' step result time
  printf '%s\n' "${step_rows[@]}"
  if ((failed_steps > 0)); then
    printf '\n%d of %d steps FAILED in %d s\n' "$failed_steps" "${#step_rows[@]}" "$SECONDS"
    return 1
  fi
  printf '\nall %d steps passed in %d s\n' "${#step_rows[@]}" "$SECONDS"
}
