// SPDX-License-Identifier: MIT
#include "tests/fuzz/laz_fuzz_case.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  alidade::test::fuzz_laz(data, size, alidade::test::k_layered_formats);
  return 0;
}
