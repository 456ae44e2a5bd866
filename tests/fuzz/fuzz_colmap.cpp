// SPDX-License-Identifier: MIT
// Any bytes as the two files of a COLMAP model, binary or text: an Error, or no more cameras than there is
// room for. The first two bytes are the length of the cameras' file and whether it is text.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "base/error.h"
#include "camera/formats/camera_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  using namespace alidade::camera;
  if (size < 2) return 0;
  const std::span<const std::uint8_t> bytes(data + 2, size - 2);
  const std::size_t length = std::min<std::size_t>(data[0] + 256u * (data[1] % 128u), bytes.size());
  const auto cameras = std::as_bytes(bytes.subspan(0, length)), images = std::as_bytes(bytes.subspan(length));
  const auto text = [](std::span<const std::byte> part) {
    return std::string_view(reinterpret_cast<const char*>(part.data()), part.size());
  };
  try {
    const CameraSet set =
        data[1] >= 128
            ? read_colmap_text(text(cameras), "cameras.txt", text(images), "images.txt")
            : read_colmap_binary(InputFile(cameras, "cameras.bin"), InputFile(images, "images.bin"));
    // An image takes nineteen bytes even as text.
    if (set.cameras.size() * 19 > images.size()) std::abort();
  } catch (const Error&) {
  }
  return 0;
}
