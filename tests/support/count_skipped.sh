#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# count_skipped.sh LOG: how many tests a run of CTest skipped, and why, from what the tests printed ("-": standard input).
# A test that skips because data is absent states its number of cases (absent_data.h).
set -euo pipefail
awk '
  /^\[==========\] [0-9]+ tests? from .* ran\./ { all += $2 }
  /: Skipped$/ { getline reason; count[reason]++; skipped++; if (reason ~ /^[0-9]+ cases? skipped: /) cases += reason + 0; else ++cases }
  /\*\*\*Skipped/ || /^Test Skipped/ { programs++ }
  END {
    printf "%d of %d tests were skipped, with %d cases, and %d test programs\n", skipped, all, cases, programs
    fflush()
    for (reason in count) printf "%6d  %s\n", count[reason], reason | "sort -k1,1nr -k2"
  }' "$1"
