#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# run_test.sh PROGRAM [OPTION...]: runs a test program with a temporary folder of its own, of which nothing stays behind.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf -- "$folder"' EXIT
TMPDIR=$folder TEST_TMPDIR=$folder "$@"
