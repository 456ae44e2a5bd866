#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# append_footer.sh LIBRARY OUTPUT VERSION: the library with the footer of an extension of DuckDB: eight fields of 32 bytes,
# last one first, and room for a signature, in a custom section as WebAssembly has it.
set -euo pipefail
field() {
  printf '%s' "$1"
  head -c "$((32 - ${#1}))" /dev/zero
}
case $(uname -m) in
  x86_64) platform=linux_amd64 ;;
  aarch64) platform=linux_arm64 ;;
  *) platform=linux_$(uname -m) ;;
esac
{
  cat -- "$1"
  printf '\x00\x93\x04\x10duckdb_signature\x80\x04'
  for text in '' '' '' C_STRUCT "$3" v1.2.0 "$platform" 4; do field "$text"; done
  head -c 256 /dev/zero
} >"$2.part"
mv -- "$2.part" "$2"
