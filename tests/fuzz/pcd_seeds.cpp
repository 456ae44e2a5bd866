// SPDX-License-Identifier: MIT
// pcd_seeds FOLDER: small PCD files of every kind of data as a start for fuzz_pcd.
#include <cstdint>
#include <vector>

#include "tests/fuzz/write_seeds.h"

int main(int count, char** arguments) {
  if (count != 2) return 2;
  const std::string header =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb intensity stamp _\nSIZE 4 4 2 4 4 8 1\nTYPE F F I F F U U\n"
      "COUNT 1 1 1 1 1 1 2\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\n";
  std::string rows;
  for (int point = 0; point < 2; ++point) {
    alidade::test::append(rows, 1.5f);
    alidade::test::append(rows, -2.5f);
    alidade::test::append(rows, std::int16_t{3});
    alidade::test::append(rows, std::uint32_t{0xff804020});
    alidade::test::append(rows, 0.5f);
    alidade::test::append(rows, std::uint64_t{1234567890123456789});
    rows += "__";
  }
  // Two literals, then references of 33 and 21 bytes that repeat them.
  std::string packed;
  alidade::test::append(packed, std::uint32_t{9});
  alidade::test::append(packed, std::uint32_t{56});
  packed += std::string("\1ab\xe0\x18\1\xe0\x0c\1", 9);
  const std::vector<std::string> seeds{
      header + "DATA ascii\n1.5 2.5 3 4.2108e+06 0.5 12 0 0\nnan 2.5 3 2.3418052e-38 0.5 12 0 0\n",
      header + "DATA binary\n" + rows, header + "DATA binary_compressed\n" + packed};
  return alidade::test::write_seeds(arguments[1], seeds);
}
