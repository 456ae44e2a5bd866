#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# make_compare_example.sh [BUILD]: writes docs/compare_example.html, the example of docs/compare.md, docs/images/compare_report.jpg, its
# first screen, and docs/images/agreement.png, with the programs of build/release or of another build folder. Requires chromium and
# gdal-bin. Takes half a minute.
set -euo pipefail
cd -- "$(dirname -- "$0")/../.."
docs=$PWD/docs
build=$(readlink -f -- "${1:-build/release}")
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
PATH=$build:$PATH
cd "$scratch"
cat >camera.json <<'CAMERA'
{ "version": 1, "model": "pinhole", "width": 420, "height": 280,
  "intrinsics": { "fx": 263.301705, "fy": 263.301705, "cx": 210, "cy": 140 },
  "pose": { "look_at": { "eye": [690023, 5324984.8, 606.8], "target": [689995, 5325002.5, 601.2] } } }
CAMERA
"$build/examples/two_scans" 600000 before.las after.las
for name in before after; do
  alidade render --cloud $name.las --camera camera.json --radius adapted --sun 150,40 --samples 24 --layers color,depth,id -o $name.exr
done
# A car has left, so the verdict is "different": exit code 1.
alidade compare before.exr after.exr --align --changes depth --change-threshold 0.3 --least-pixels 60 \
  --fail-above 'flip=0.2,depth_5cm<95,regions=0' --reference-cloud before.las --reference-points gone.las \
  --report page.html --report-pictures jpeg || (($? == 1))
for name in before after; do
  alidade render --cloud $name.las --camera camera.json --surface disc --samples 1 --layers color,depth,depth.sigma -o $name-sigma.exr
done
alidade compare before-sigma.exr after-sigma.exr --agreement-map agreement.png
chromium --headless --no-sandbox --disable-gpu --window-size=1000,1010 --screenshot=page.png "file://$PWD/page.html"
gdal_translate -q -b 1 -b 2 -b 3 -of JPEG -co QUALITY=88 page.png page.jpg
mv page.html "$docs/compare_example.html"
mv agreement.png "$docs/images/agreement.png"
mv page.jpg "$docs/images/compare_report.jpg"
