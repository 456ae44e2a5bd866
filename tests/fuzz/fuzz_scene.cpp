// SPDX-License-Identifier: MIT
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/error.h"
#include "camera/camera_json.h"
#include "renderer/read_scene.h"

// Any bytes are a scene, a camera, or an Error. The folder does not exist, so that a camera's name leads
// nowhere.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    alidade::renderer::parse_scene(text, "/nonexistent/scene.json");
  } catch (const alidade::Error&) {
  }
  try {
    alidade::camera::parse_camera(text, "/nonexistent/camera.json");
  } catch (const alidade::Error&) {
  }
  return 0;
}
