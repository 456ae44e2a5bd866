#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# parquet_test.sh PROGRAM FOLDER [DATA]: what `alidade convert` writes as Parquet, read by hyparquet, DuckDB and DataFusion, has
# the values that `alidade sql` gives, and statements their answers, also from the extension
# beside PROGRAM. FOLDER keeps these readers, which come from npm. DATA: a folder of real clouds. Left out
# (code 77) where Node or the readers cannot be had.
set -euo pipefail
program=$(readlink -f -- "$1")
here=$(readlink -f -- "$(dirname -- "${BASH_SOURCE[0]}")")
mkdir -p -- "$2"
readers=$(readlink -f -- "$2")
data=${3:-}
for tool in node npm; do
  if ! command -v "$tool" >/dev/null; then
    echo "left out: no $tool, which runs the readers of Parquet (Debian packages nodejs and npm)"
    exit 77
  fi
done
if ! cmp -s "$here/package.json" "$readers/installed.json"; then
  cp "$here/package.json" "$readers/package.json"
  if ! (cd "$readers" && npm install --no-audit --no-fund --no-package-lock >npm.log 2>&1); then
    echo "left out: npm cannot install the readers of Parquet; see $readers/npm.log"
    exit 77
  fi
  cp "$here/package.json" "$readers/installed.json"
fi
cp "$here"/*.mjs "$readers"
if command -v ogrinfo >/dev/null && ogrinfo --formats | grep -q '^ *Parquet '; then gdal=yes; else gdal=no; fi
[[ $gdal == yes ]] || echo "left out: GDAL has no driver for Parquet here"

scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
cd "$scratch"
written=()
# write CLOUD [OPTION...]: as Parquet, and as the rows of an SQLite table
write() {
  local cloud=$1 name
  shift
  name=${#written[@]}_$(basename -- "$cloud")
  "$program" convert "$cloud" "$@" -o "$name.parquet" -q 2>warnings.txt || { cat warnings.txt >&2 && return 1; }
  "$program" sql load "$cloud" rows.db --overwrite -q 2>warnings.txt
  "$program" sql rows.db "SELECT * FROM points ORDER BY id" --csv >"$name.csv"
  if [[ $gdal == yes ]]; then
    [[ $(ogrinfo -so -al "$name.parquet" | sed -n 's/^Feature Count: //p') == $(($(wc -l <"$name.csv") - 1)) ]]
  fi
  written+=("$name.parquet")
}
"$program" generate courtyard --points 70000 -o yard.las -q
"$program" generate courtyard --points 2000 -o few.las -q
write yard.las
write few.las --geometry
node "$readers/odd_cloud.mjs" odd.las
write odd.las
# The bytes depend neither on memory nor on the number of threads.
"$program" convert yard.las -o whole.parquet -q
"$program" convert yard.las -o pieces.parquet --memory 2M --threads 3 -q
cmp whole.parquet pieces.parquet
# Text has x, y and z from another writer.
"$program" convert yard.las -o yard.csv -q
node "$readers/compare_text.mjs" whole.parquet yard.csv
if [[ -d $data ]]; then
  for cloud in lidar/extrabytes.las lidar/1_4_w_evlr.las malformed/gps-time-nan.las malformed/no-points.las \
    laz_vectors/microz.laz lidar_rgb/warsaw_small.las text/ripple.pts pcd/lamppost.pcd e57/ColouredCubeFloat.e57; do
    write "$data/$cloud"
  done
  write "$data/lidar/epsg_4326.las" --geometry
else
  echo "left out: no folder of real clouds"
fi
node "$readers/compare.mjs" "${written[@]}"
# The paper's statements, which `alidade sql rewrite` writes for other engines.
"$program" generate courtyard --points 20000 --seed 3 -o site.las -q
"$program" sql load site.las site.db -q
"$program" convert site.las -o site.parquet --group-points 1024 -q
for form in rows sums; do "$here/../../../../tests/support/random_statements.py" "$form" 200 >"$form.sql"; done
node "$readers/statements.mjs" "$program" site.las site.db site.parquet rows.sql sums.sql
# DuckDB's extension.
extension=$(dirname -- "$program")/alidade.duckdb_extension
if [[ -f $extension ]]; then node "$readers/extension.mjs" "$program" "$extension" site.las site.db; fi
echo "all files are read alike"
