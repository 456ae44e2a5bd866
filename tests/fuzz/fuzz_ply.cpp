// SPDX-License-Identifier: MIT
#include "tests/fuzz/fuzz_reader.h"

// A vertex takes two bytes at least: x and y as char.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  alidade::test::fuzz_damaged(alidade::open_ply, data, size, 1);
  return 0;
}
