#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Prints the ten longest sources: one idea per file, about 100 lines, 400 at most.
set -euo pipefail
cd -- "$(dirname -- "$0")/../.."
echo "ten longest files (lines):"
find octree simulation renderer visibility compare tools database tests docs \( -name '*.h' -o -name '*.cpp' -o -name '*.sh' \) -print0 |
  xargs -0 wc -l | grep -v ' total$' | sort -rn | awk 'NR <= 10'
