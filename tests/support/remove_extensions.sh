#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# remove_extensions.sh drawn|each|NAME...: shows that extensions can be taken away. In a copy of the tree it removes the folder of
# an extension, builds the program of the rest and tries it. drawn: one extension, by the date; each: one after another, and at
# last all of them together.
set -euo pipefail
cd -- "$(dirname -- "$0")/../.."
copy=$PWD/output/without_extension
names=()
for file in extensions/*/CMakeLists.txt; do names+=("$(basename -- "$(dirname -- "$file")")"); done
case ${1:-} in
  drawn) removals=("${names[$(($(date +%s) / 86400 % ${#names[@]}))]}") ;;
  each) removals=("${names[@]}" "${names[*]}") ;;
  '') sed -n '3,5s/^# //p' "$0" >&2 && exit 2 ;;
  *) removals=("$@") ;;
esac

# Files have the names that they have in the tree itself, so that a compiler cache has what that was built of.
export CCACHE_BASEDIR=$copy
launcher=()
if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi

# As someone builds it who never had the extension.
build() {
  cmake --preset release "${launcher[@]}" -DALIDADE_BUILD_TESTS=OFF -DALIDADE_UNITY=ON >configure.log
  cmake --build build/release --parallel "$(nproc)" --target alidade >build.log || { cat build.log && exit 1; }
}

try() {
  local program=$copy/build/release/alidade
  "$program" generate courtyard --points 2e4 --seed 1 -o site.las -q
  "$program" render site.las --size 60x40 --samples 1 -o site.png -q
  "$program" visibility raster site.las --observer 689995,5324988,601.7 --resolution 2 -o map.tif -q
  "$program" sql site.las "SELECT count(*) FROM points" --csv -q | grep -qx 20000
  "$program" manual share -q
}

for removal in "${removals[@]}"; do
  begin=$SECONDS
  echo "without ${removal// /, } ..."
  mkdir -p "$copy"
  # What was built for the last one stays: only what depends on the list is built again.
  find "$copy" -mindepth 1 -maxdepth 1 ! -name build -exec rm -rf {} +
  git ls-files -z --cached | tar -c --null --files-from=- | tar -x -C "$copy"
  (
    cd "$copy"
    for name in $removal; do rm -r "extensions/$name"; done
    build
    try
  )
  echo "without ${removal// /, }: the program builds and runs ($((SECONDS - begin)) s)"
done
rm -rf "$copy"
