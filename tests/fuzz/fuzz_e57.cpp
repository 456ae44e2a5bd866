// SPDX-License-Identifier: MIT
// Any bytes as an E57 file, as they are and with checksums made right: an Error, or points and images that
// lie inside.
#include <cstdlib>
#include <string>
#include <vector>

#include "cloud/e57/e57_file.h"
#include "tests/cloud/e57/e57_builder.h"
#include "tests/fuzz/fuzz_reader.h"

namespace {

// A section holds eight points a byte at most: those of one-bit fields and constants.
constexpr std::size_t k_most_per_byte = 8;

void read_images(const std::vector<std::byte>& bytes) {
  try {
    alidade::E57File file(alidade::InputFile(bytes, "input"));
    for (const alidade::E57Image& image : file.document().images) {
      for (const alidade::E57Representation& representation : image.representations) {
        std::uint64_t length = 0;
        file.read_blob(representation.blob,
                       [&](std::span<const std::byte> piece) { length += piece.size(); });
        if (length != representation.blob.length || length > bytes.size()) std::abort();
      }
    }
  } catch (const alidade::Error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  alidade::test::fuzz_damaged(alidade::open_e57, data, size, k_most_per_byte);
  const auto input = std::as_bytes(std::span(data, size));
  std::vector<std::byte> bytes(input.begin(), input.end());
  alidade::test::seal_e57(bytes);
  alidade::test::fuzz_damaged(alidade::open_e57, reinterpret_cast<const std::uint8_t*>(bytes.data()), size,
                              k_most_per_byte);
  read_images(bytes);
  return 0;
}
