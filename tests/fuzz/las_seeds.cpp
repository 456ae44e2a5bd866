// SPDX-License-Identifier: MIT
// las_seeds FOLDER: writes a small LAS file of every version and point format as a start for fuzz_las.
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/cloud/las/las_builder.h"

int main(int count, char** arguments) {
  if (count != 2) return 2;
  const std::filesystem::path folder = arguments[1];
  std::filesystem::create_directories(folder);
  for (int format = 0; format < 11; ++format) {
    for (int version = alidade::test::oldest_las_version(format); version <= 4; ++version) {
      const std::vector<std::byte> bytes = build_las(alidade::test::sample_las(version, format, 3));
      const std::string name =
          "version_1_" + std::to_string(version) + "_format_" + std::to_string(format) + ".las";
      std::ofstream stream(folder / name, std::ios::binary);
      stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
      if (!stream) return 1;
    }
  }
  return 0;
}
