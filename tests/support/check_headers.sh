#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Checks the architecture by the includes: header_order.txt lists all headers in reading order, and a header includes none
# that is listed later; a room includes only from the rooms that stand below it in rooms.txt; the libraries that only one
# room may talk to stay there.
set -euo pipefail
cd -- "$(dirname -- "$0")/../.."
order=tests/support/header_order.txt
problems=0

complain() {
  echo "$1" >&2
  problems=$((problems + 1))
}

declare -A position=()
while read -r header; do
  position[$header]=${#position[@]}
  if [[ ! -f $header ]]; then complain "$order: $header does not exist"; fi
done < <(grep -v -e '^#' -e '^$' "$order")

declare -A allowed=()
rooms=()
while IFS=: read -r room below; do
  rooms+=("$room")
  allowed[$room]=" $room $below "
done < <(grep -v -e '^#' -e '^$' tests/support/rooms.txt)

# Clang 14 compiles the fuzz targets, and not these of libstdc++ 12.
while read -r place; do
  complain "$place: clang 14 does not compile views, ranges::rotate and subrange: use iterators"
done < <(grep -rnoE 'std::(ranges::)?views::[a-z_]+|std::ranges::(rotate|subrange)' "${rooms[@]}" tests --include='*.h' --include='*.cpp')

# FILE:INCLUDED for every include of the repository's own files
while IFS=: read -r file included; do
  room=${file%%/*}
  # Generated headers are listed nowhere.
  if [[ ${allowed[$room]} != *" ${included%%/*} "* && -n ${allowed[${included%%/*}]:-} ]]; then
    complain "$file: includes $included; $room may include only from:${allowed[$room]}"
  fi
  if [[ $file/$included =~ ^extensions/([^/]+)/.*/extensions/([^/]+)/ && ${BASH_REMATCH[1]} != "${BASH_REMATCH[2]}" ]]; then
    complain "$file: includes $included; an extension includes nothing of another one"
  fi
  if [[ $file != *.h ]]; then continue; fi
  if [[ -n ${position[$included]:-} && -n ${position[$file]:-} ]] && ((position[$included] >= position[$file])); then
    complain "$file: includes $included, which is listed later in $order"
  fi
done < <(grep -rHoE '^ *# *include "[^"]+"' "${rooms[@]}" --include='*.h' --include='*.cpp' | sed -E 's/: *# *include "([^"]+)"/:\1/')

while read -r header; do
  if [[ -z ${position[$header]:-} ]]; then complain "$header: not in $order; add it behind the headers it includes"; fi
done < <(find "${rooms[@]}" -name '*.h' ! -path '*/tests/*' | sort)

# only WHERE WHAT PATTERN: headers that match the pattern are included in no other room
only() {
  while read -r file; do
    complain "$file: $2 belongs into $1"
  done < <(grep -rlE "include *<($3)" "${rooms[@]}" tests docs --include='*.h' --include='*.cpp' | grep -vE "^($1|tests|extensions/[^/]+/tests)/" || true)
}
only octree/simd 'raw intrinsics' '(imm|xmm|emm|tmm|smm|avx)[a-z0-9]*intrin\.h>'
only geo 'GDAL' '(gdal|ogr|cpl|gdalwarper)[a-z_]*\.h>'
only 'image/backend' 'OpenImageIO' 'OpenImageIO/'
only 'image/backend' 'FreeType' 'ft2build\.h>'
only 'tools' 'CLI11' 'CLI/'

if ((problems > 0)); then
  echo "$problems problems with includes" >&2
  exit 1
fi
echo "includes: ${#position[@]} headers in order, ${#rooms[@]} rooms apart"
