// SPDX-License-Identifier: MIT
// Any bytes through the LAS reader: an Error or a cloud whose size the input can pay for.
#include <cstdint>
#include <cstdlib>

#include "base/error.h"
#include "cloud/cloud_reader.h"
#include "cloud/read_cloud.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  for (const bool partial : {false, true}) {
    try {
      alidade::open_las(alidade::InputFile(bytes, "input"),
                        partial ? alidade::Damage::read_over : alidade::Damage::reject);
      // The same file twice also goes through the joining of lattices, columns and records.
      alidade::CloudInputs files;
      files.inputs.push_back(alidade::cloud_in_memory(bytes, "first"));
      files.inputs.push_back(alidade::cloud_in_memory(bytes, "second"));
      const alidade::PointCloud cloud = alidade::read_cloud(files, {.partial = partial});
      if (cloud.size() * 20 > 2 * size) std::abort();
    } catch (const alidade::Error&) {
    }
  }
  return 0;
}
