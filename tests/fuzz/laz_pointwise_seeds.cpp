// SPDX-License-Identifier: MIT
// laz_pointwise_seeds FOLDER: small pointwise chunks of all formats as a start for fuzz_laz_pointwise.
#include "tests/fuzz/laz_fuzz_case.h"

int main(int count, char** arguments) {
  if (count != 2) return 2;
  return alidade::test::write_laz_seeds(arguments[1], alidade::test::k_pointwise_formats);
}
