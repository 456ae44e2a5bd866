#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Checks the architecture as the includes tell it: header_order.txt lists all headers in reading order, and a header
# includes none that stands later; no room knows a room beside it; raw intrinsics stay in octree/simd.
set -euo pipefail
cd -- "$(dirname -- "$0")/../.."
order=tests/support/header_order.txt
problems=0

complain() {
  echo "$1" >&2
  problems=$((problems + 1))
}

declare -A place=()
while read -r header; do
  place[$header]=${#place[@]}
  if [[ ! -f $header ]]; then complain "$order: $header does not exist"; fi
done < <(grep -v -e '^#' -e '^$' "$order")

# includes FILE: what it includes from this repository
includes() { sed -nE 's/^ *# *include "([^"]+)".*/\1/p' "$1"; }

while read -r header; do
  if [[ -z ${place[$header]:-} ]]; then
    complain "$header: not in $order; add it behind the headers it includes"
    continue
  fi
  while read -r included; do
    # Generated headers stand in no list.
    if [[ -z ${place[$included]:-} ]]; then continue; fi
    if ((place[$included] >= place[$header])); then complain "$header: includes $included, which stands later in $order"; fi
  done < <(includes "$header")
done < <(find octree simulation renderer visibility compare tools database -name '*.h' | sort)

# room FOLDER ALLOWED...: sources of FOLDER include only from the allowed folders
room() {
  local folder=$1 file included
  shift
  while read -r file; do
    while read -r included; do
      local allowed=no name
      for name in "$@"; do
        if [[ $included == "$name"/* ]]; then allowed=yes; fi
      done
      if [[ $allowed == no ]]; then complain "$file: includes $included; $folder may include only: $*"; fi
    done < <(includes "$file")
  done < <(find "$folder" \( -name '*.h' -o -name '*.cpp' \) | sort)
}
room octree octree
room simulation octree simulation
room renderer octree renderer
room visibility octree renderer visibility
room compare octree renderer compare
room database octree database

while read -r file; do
  complain "$file: raw intrinsics belong into octree/simd"
done < <(grep -rlE 'include *<(imm|xmm|emm|tmm|smm|avx)[a-z0-9]*intrin\.h>' octree simulation renderer visibility compare tools database tests docs --include='*.h' --include='*.cpp' | grep -v '^octree/simd/')

if ((problems > 0)); then
  echo "$problems problems with includes" >&2
  exit 1
fi
echo "includes: ${#place[@]} headers in order, rooms apart"
