#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# check_words.sh [--all | BASE]: prints lines with the words of words.txt, of all sources and documents or of those that have
# changed since BASE (default: main, or its remote's). It never fails: each line is for a person to judge.
set -euo pipefail
cd -- "$(dirname -- "$0")/../.."

lines() {
  if [[ ${1:-} == --all ]]; then
    git grep -n '' -- '*.h' '*.cpp' '*.md' tools/manuals ':!tests/support/words.txt' ':!CHANGELOG.md'
    return
  fi
  local base=${1:-}
  for name in main origin/main; do
    if [[ -z $base ]] && git rev-parse -q --verify "$name" >/dev/null; then base=$(git merge-base HEAD "$name"); fi
  done
  git diff --unified=0 "${base:-HEAD}" -- '*.h' '*.cpp' '*.md' tools/manuals |
    awk '/^\+\+\+ b\// { file = substr($0, 7); next }
         /^@@/ { split($3, at, /[+,]/); line = at[2]; next }
         /^\+/ { print file ":" line++ ":" substr($0, 2) }'
}

found=$(mktemp)
trap 'rm -f -- "$found"' EXIT
lines "$@" >"$found"
grep -v '^#' tests/support/words.txt | while IFS=$'\t' read -r pattern instead; do
  { grep -P ":\d+:.*(?:$pattern)" "$found" || true; } | sed "s|\$|    [$instead]|"
done
