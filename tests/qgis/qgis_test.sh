#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# qgis_test.sh PROGRAM: runs every algorithm of the Processing provider by QGIS itself, without a window, on a simulated
# courtyard. Left out (code 77) where QGIS is not installed.
set -euo pipefail
program=$(readlink -f -- "$1")
plugin=$(readlink -f -- "$(dirname -- "${BASH_SOURCE[0]}")/../../qgis/alidade")
# Debian's qgis_process passes an option that it does not know.
process=$(command -v qgis_process.bin || command -v qgis_process || true)
if [[ -z $process ]]; then
  echo "left out: QGIS is not installed (Debian packages qgis and python3-qgis)"
  exit 77
fi
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
export HOME=$scratch XDG_RUNTIME_DIR=$scratch/run QT_QPA_PLATFORM=offscreen ALIDADE_PROGRAM=$program
unset PYTHONPATH
plugins=$HOME/.local/share/QGIS/QGIS3/profiles/default/python/plugins
mkdir -p "$plugins" "$XDG_RUNTIME_DIR"
chmod 700 "$XDG_RUNTIME_DIR"
ln -s "$plugin" "$plugins/alidade"
cd "$scratch"
"$program" generate courtyard --points 1e5 -o yard.las -q
feature() {
  printf '{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"name":"gate"},"geometry":{"type":"%s","coordinates":%s}}]}' "$1" "$2"
}
# Longitude and latitude, to be moved by the program and by QGIS.
lon_lat() { echo "$1 $2" | gdaltransform -s_srs EPSG:32632 -t_srs EPSG:4326 -output_xy | sed 's/ /,/'; }
feature Point "[$(lon_lat 689995 5324985)]" >observer.geojson
feature LineString "[[$(lon_lat 689985 5324985)],[$(lon_lat 690015 5325015)]]" >line.geojson

"$process" plugins enable alidade >plugins.log 2>&1
# run ALGORITHM OUTPUT PARAMETER=VALUE...
run() {
  local algorithm=$1 output=$2
  shift 2
  if ! "$process" run "alidade:$algorithm" -- CLOUD=yard.las "$@" OUTPUT="$output" >run.log 2>&1 || [[ ! -s $output ]]; then
    echo "qgis_test.sh: alidade:$algorithm wrote no $output" >&2
    cat run.log >&2
    exit 1
  fi
}
points() { "$program" info "$1" --json | sed -n 's/^  "points": \([0-9]*\),/\1/p'; }
run overview overview.png SIZE=60x40 SAMPLES=1
run orthophoto ortho.tif RESOLUTION=1 SAMPLES=1
run ground_layers surface.tif RESOLUTION=1
run viewshed seen.tif OBSERVERS=observer.geojson RESOLUTION=2
run viewshed part.tif OBSERVERS=observer.geojson RESOLUTION=1 "EXTENT=689990,690010,5324990,5325010 [EPSG:32632]"
run visible_points seen.laz OBSERVERS=observer.geojson
run horizon horizon.csv OBSERVERS=observer.geojson
run sun_hours sun.tif RESOLUTION=5
run profile corridor.laz LINE=line.geojson WIDTH=0.5
run convert thin.laz CLASSES=2,6 SPACING=1
[[ $(points seen.laz) == 100000 ]]
(($(points corridor.laz) > 100 && $(points corridor.laz) < 5000))
(($(points thin.laz) > 1000 && $(points thin.laz) < 50000))
gdalinfo part.tif >part.txt && grep -q 'Size is 20, 20' part.txt
gdalinfo seen.tif >seen.txt && grep -q 'ID\["EPSG",32632\]' seen.txt
grep -q '^azimuth,elevation,' horizon.csv
# Errors are the program's own.
if "$process" run alidade:convert -- CLOUD=missing.las OUTPUT=none.laz >run.log 2>&1; then
  echo "qgis_test.sh: a missing cloud was no error" >&2
  exit 1
fi
grep -q 'missing.las: cannot open the file' run.log
echo "all algorithms ran"
