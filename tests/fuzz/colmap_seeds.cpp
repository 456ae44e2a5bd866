// SPDX-License-Identifier: MIT
// colmap_seeds FOLDER: small COLMAP models, binary with every camera model and text, as a start for
// fuzz_colmap.
#include <vector>

#include "tests/camera/colmap_builder.h"
#include "tests/fuzz/write_seeds.h"

namespace {

/// As fuzz_colmap takes two files apart.
std::string joined(const std::string& cameras, const std::string& images, bool text) {
  std::string bytes;
  bytes += static_cast<char>(cameras.size() % 256);
  bytes += static_cast<char>(cameras.size() / 256 + (text ? 128 : 0));
  return bytes + cameras + images;
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) return 2;
  constexpr std::size_t k_parameters[] = {3, 4, 4, 5, 8, 8, 12, 5, 4, 5, 12, 16, 4, 5, 3, 4, 6, 2};
  std::vector<std::string> seeds;
  for (int model = 0; model < 18; ++model) {
    alidade::test::ColmapBuilder builder;
    builder.camera(1, model, 64, 48, std::vector<double>(k_parameters[model], 0.5));
    builder.image(1, {1, 0, 0, 0}, {1, 2, 3}, 1, "a.jpg", 2).image(2, {0, 1, 0, 0}, {1, 2, 3}, 1, "b.jpg");
    seeds.push_back(joined(builder.cameras(), builder.images(), false));
  }
  seeds.push_back(joined("# cameras\n1 OPENCV 64 48 50 51 32 24 0.1 0.01 0.001 -0.002\n",
                         "1 1 0 0 0 1 2 3 1 a.jpg\n1.5 2.5 -1\n2 1 0 0 0 1 2 3 1 b.jpg\n\n", true));
  seeds.push_back(
      joined("1 PINHOLE 64 48 50 51 32 24\n", "1 1 0 0 0 1 2 3 1 a.jpg\r2 1 0 0 0 1 2 3 1 b c.jpg\n", true));
  return alidade::test::write_seeds(arguments[1], seeds);
}
