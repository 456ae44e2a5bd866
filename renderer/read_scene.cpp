// SPDX-License-Identifier: MIT
#include "renderer/read_scene.h"

#include "base/input_file.h"
#include "renderer/scene_forms.h"

namespace alidade::renderer {

Scene parse_scene(std::string_view text, const std::filesystem::path& name) {
  const JsonDocument document = parse_json(std::string(text), name.string());
  return scene_form().read(JsonNode(document));
}

Scene read_scene(const std::filesystem::path& file) {
  return parse_scene(read_text_file(file), file);
}

}  // namespace alidade::renderer
