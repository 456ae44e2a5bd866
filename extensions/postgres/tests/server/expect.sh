# SPDX-License-Identifier: MIT
# Counts in $failures what is not as expected. To be sourced.
failures=0

# expect NAME WANTED FOUND
expect() {
  if [[ $2 != "$3" ]]; then
    printf 'FAILED: %s\nexpected: %s\nfound:    %s\n' "$1" "$2" "$3" >&2
    failures=$((failures + 1))
  fi
}
