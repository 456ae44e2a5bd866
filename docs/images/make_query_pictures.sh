#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# make_query_pictures.sh [PROGRAM [NAME...]]: renders the pictures of docs/queries.md, or only those named ("cone"), with
# build/release/alidade or another program. Takes python3 and some minutes.
set -euo pipefail
cd -- "$(dirname -- "$0")/../.."
program=${1:-build/release/alidade}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"$program" generate courtyard --points 6e6 -o "$scratch/site.las" -q
"$program" index "$scratch/site.las" -o "$scratch/site.alidade" -q
python3 docs/images/query_pictures.py "$program" "$scratch/site.alidade" docs/images "${@:2}"
