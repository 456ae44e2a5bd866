// SPDX-License-Identifier: MIT
#include "cloud/pcd/pcd_file.h"
#include "tests/fuzz/fuzz_reader.h"

// A point takes two bytes at least, before compression.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  alidade::test::fuzz_damaged(alidade::open_pcd, data, size, alidade::k_lzf_largest_ratio);
  return 0;
}
