// SPDX-License-Identifier: MIT
// ply_seeds FOLDER: small PLY files of every encoding as a start for fuzz_ply.
#include <cstdint>
#include <vector>

#include "tests/fuzz/write_seeds.h"

int main(int count, char** arguments) {
  if (count != 2) return 2;
  const std::string elements =
      "element face 1\nproperty list uchar short indices\nproperty uchar tag\n"
      "element vertex 2\nproperty float x\nproperty double y\nproperty short z\nproperty uchar red\n"
      "property uchar green\nproperty uchar blue\nproperty list char uchar list\nproperty float nx\n"
      "property float ny\nproperty float nz\nproperty ushort intensity\nproperty uint other\n"
      "property uchar class_flags\nproperty double gps_time\nend_header\n";
  std::vector<std::string> seeds{
      "ply\nformat ascii 1.0\ncomment c\nobj_info o\n" + elements +
          "3 0 1 2 9\n1.5 2.5 3 4 5 6 2 7 8 0 0 1 500 70000 3 12.5\n-1e3 nan 3 4 5 6 0 0 0 1 5 7 3 12.5\n",
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int y\nproperty float red\n"
      "property float green\nproperty float blue\nproperty float intensity\nend_header\n1 2 0.5 1 0 -3\n"};
  for (const char* order : {"little", "big"}) {
    std::string text = std::string("ply\nformat binary_") + order + "_endian 1.0\n" + elements;
    text += std::string("\2\1\0\2\0\7", 6);
    for (int vertex = 0; vertex < 2; ++vertex) {
      alidade::test::append(text, 1.5f);
      alidade::test::append(text, 2.5);
      alidade::test::append(text, std::int16_t{3});
      text += std::string("rgb\1L", 5);
      for (int axis = 0; axis < 3; ++axis) alidade::test::append(text, 0.5f);
      alidade::test::append(text, std::uint16_t{500});
      alidade::test::append(text, std::uint32_t{70000});
      alidade::test::append(text, std::uint8_t{3});
      alidade::test::append(text, 12.5);
    }
    seeds.push_back(text);
  }
  return alidade::test::write_seeds(arguments[1], seeds);
}
