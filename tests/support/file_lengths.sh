#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Prints files and lines of each room, the longest sources and the shortest. Fails where a production file has more than
# 600 lines.
set -euo pipefail
cd -- "$(dirname -- "$0")/../.."
rooms=(base cloud octree surface mesh geo image camera renderer visibility compare database simulation jobs tools extensions)
lengths=$(find "${rooms[@]}" \( -name '*.h' -o -name '*.cpp' \) ! -path '*/tests/*' -exec wc -l {} + | grep -v ' total$' | sort -rn)
awk '{ split($2, path, "/"); files[path[1]]++; lines[path[1]] += $1; all += $1 }
     END { for (room in files) printf "  %-12s %4d files %6d lines\n", room, files[room], lines[room]
           printf "  %-12s %4d files %6d lines\n", "together", NR, all }' <<<"$lengths" | sort
echo "longest:"
sed -n '1,6p' <<<"$lengths"
echo "shortest:"
tail -n 6 <<<"$lengths"
if ((10#$(awk 'NR == 1 { print $1 }' <<<"$lengths") > 600)); then
  echo "a file has more than 600 lines; split it" >&2
  exit 1
fi
