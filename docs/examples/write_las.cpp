// SPDX-License-Identifier: MIT
// write_las CLOUD... OUT.las: joins clouds of any format into one LAS file.
#include "cloud/las/write_las.h"
#include "cloud/read_cloud.h"

int main(int count, char** arguments) {
  using namespace alidade;
  const std::vector<std::filesystem::path> files(arguments + 1, arguments + count - 1);
  LasWriteOptions options;
  options.overwrite = true;
  write_las(arguments[count - 1], read_cloud(files), options);
}
