#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# remove_extensions.sh drawn|each|NAME...: shows that extensions can be taken away. In a copy of the tree it removes the folder of
# one extension after another, builds the program of the rest and tries it. drawn: one extension, by the date; each: one
# after another, and at last all of them together.
set -euo pipefail
cd -- "$(dirname -- "$0")/../.."
here=$PWD
copy=$here/output/without_extension

cmakes=(extensions/*/CMakeLists.txt)
names=()
for file in "${cmakes[@]}"; do
  file=${file#extensions/}
  names+=("${file%/CMakeLists.txt}")
done
case ${1:-} in
  drawn) removals=("${names[$(($(date +%s) / 86400 % ${#names[@]}))]}") ;;
  each) removals=("${names[@]}" "${names[*]}") ;;
  '') sed -n '3,5s/^# //p' "$0" >&2 && exit 2 ;;
  *) removals=("$@") ;;
esac

# Names of files relative to the top folder: a compiler cache then has what the tree itself was built of.
export CCACHE_BASEDIR=$copy
launcher=()
if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi

# The program as it would be built by someone who never had the extension.
build() {
  cmake --preset release "${launcher[@]}" -DALIDADE_BUILD_TESTS=OFF -DALIDADE_UNITY=ON >configure.log
  cmake --build build/release --parallel "$(nproc)" --target alidade >build.log || { cat build.log && return 1; }
}

try() {
  local program=$copy/build/release/alidade
  "$program" generate courtyard --points 2e4 --seed 1 -o site.las --overwrite -q
  "$program" render site.las --size 60x40 --samples 1 -o site.png --overwrite -q
  "$program" visibility raster site.las --observer 689995,5324988,601.7 --resolution 2 -o map.tif --overwrite -q
  "$program" sql site.las "SELECT count(*) FROM points" >count.txt
  "$program" manual share --overwrite -q
  [[ -s site.png && -s map.tif ]] && grep -q 20000 count.txt
}

for removal in "${removals[@]}"; do
  begin=$SECONDS
  mkdir -p "$copy"
  # What the last removal built stays: only what depends on the list is built again.
  find "$copy" -mindepth 1 -maxdepth 1 ! -name build -exec rm -rf {} +
  git ls-files -z --cached --others --exclude-standard | tar -c --null --files-from=- --ignore-failed-read 2>/dev/null | tar -x -C "$copy"
  (
    cd "$copy"
    for name in $removal; do
      if [[ ! -d extensions/$name ]]; then echo "unknown extension $name; expected one of ${names[*]}" >&2 && exit 2; fi
      rm -r "extensions/$name"
    done
    build
    try
  ) || { echo "the core does not build or run without ${removal// /, }" >&2 && exit 1; }
  echo "without ${removal// /, }: the program builds and runs ($((SECONDS - begin)) s)"
done
rm -rf "$copy"
