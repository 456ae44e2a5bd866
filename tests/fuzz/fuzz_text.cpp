// SPDX-License-Identifier: MIT
#include "tests/fuzz/fuzz_reader.h"

// XYZ, CSV, PTS and PTX. A point takes four bytes at least: "1 2" and the end of its line.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  alidade::test::fuzz_damaged(alidade::open_text, data, size, 1);
  alidade::test::fuzz_damaged(alidade::open_ptx, data, size, 1);
  return 0;
}
