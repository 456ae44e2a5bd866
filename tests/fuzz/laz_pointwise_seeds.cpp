// SPDX-License-Identifier: MIT
// laz_pointwise_seeds FOLDER: small pointwise chunks of all formats as a start for fuzz_laz_pointwise.
#include <random>
#include <string>
#include <vector>

#include "octree/cloud/laz/pointwise_codec.h"
#include "tests/fuzz/laz_fuzz_case.h"
#include "tests/fuzz/write_seeds.h"

int main(int count, char** arguments) {
  if (count != 2) return 2;
  std::mt19937 random(1);
  std::vector<std::string> seeds;
  for (char format = 0; format < 6; ++format)
    for (char version = 0; version < 2; ++version)
      for (const char points : {1, 2, 40}) {
        std::string seed{format, static_cast<char>(format % 3), version, points};
        const alidade::test::LazCase laz = alidade::test::laz_case(std::as_bytes(std::span(seed)));
        const alidade::LazLayout layout = laz.layout(0);
        // Every record repeats most of the one before.
        const std::size_t size = layout.record_size();
        std::vector<std::byte> records(laz.point_count * size);
        for (std::size_t i = size; i < records.size(); ++i) {
          records[i] = records[i - size];
          if (random() % 8 == 0) records[i] = static_cast<std::byte>(random() >> 8);
        }
        for (const std::byte byte : alidade::PointwiseEncoder(layout).encode(records))
          seed += static_cast<char>(byte);
        seeds.push_back(seed);
      }
  return alidade::test::write_seeds(arguments[1], seeds);
}
