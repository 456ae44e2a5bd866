// SPDX-License-Identifier: MIT
// copc_seeds FOLDER: small COPC files as a start for fuzz_copc.
#include "tests/cloud/copc/copc_builder.h"
#include "tests/fuzz/write_seeds.h"

int main(int count, char** arguments) {
  if (count != 2) return 2;
  std::vector<std::string> seeds;
  for (const std::size_t points : {1u, 20u, 90u}) {
    const std::vector<std::byte> bytes = alidade::test::build_copc(points, 10).bytes;
    seeds.emplace_back(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  return alidade::test::write_seeds(arguments[1], seeds);
}
