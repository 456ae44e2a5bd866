// SPDX-License-Identifier: MIT
#include "tools/render/depth_transforms.h"

#include <cassert>
#include <map>
#include <nlohmann/json.hpp>

#include "base/input_file.h"
#include "base/output_file.h"
#include "base/shown_text.h"

namespace alidade::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;  // keeps the order of keys

std::string photo_of(const Json& frame) {
  std::string name = frame.at("file_path").get<std::string>();
  std::ranges::replace(name, '\\', '/');
  return name;
}

fs::path folder_of(const fs::path& file) {
  return fs::weakly_canonical(fs::absolute(file).parent_path());
}

/// Empty unless the text is an object with frames that name photographs.
Json parse_transforms(const std::string& text) {
  Json top = Json::parse(text, nullptr, false);
  if (!top.is_object() || !top.contains("frames") || !top["frames"].is_array()) return {};
  for (const Json& frame : top["frames"])
    if (!frame.is_object() || !frame.contains("file_path") || !frame["file_path"].is_string()) return {};
  return top;
}

}  // namespace

DepthTransforms read_depth_transforms(const fs::path& input, const fs::path& output) {
  constexpr std::uintmax_t k_largest = 1u << 30;
  std::error_code error;
  DepthTransforms transforms{input, output, {}};
  if (!fs::is_directory(input, error)) transforms.text = read_text_file(input, k_largest);
  const Json top = parse_transforms(transforms.text);
  if (top.is_null())
    throw file_error(input, "--transforms-out requires the cameras of a transforms.json",
                     "a JSON file with \"frames\" and \"file_path\"");
  if (folder_of(input) == folder_of(output)) return transforms;
  for (const Json& frame : top["frames"]) {
    if (fs::path(photo_of(frame)).is_absolute()) continue;
    throw file_error(output, "photographs have names relative to the folder of " + input.string(),
                     "a file in that folder");
  }
  return transforms;
}

void write_depth_transforms(const DepthTransforms& transforms, std::span<const View> views,
                            std::span<const fs::path> files, bool overwrite) {
  assert(views.size() == files.size());
  const fs::path folder = folder_of(transforms.output);
  std::map<std::string, fs::path> depth_of;
  for (std::size_t i = 0; i < views.size(); ++i)
    depth_of[views[i].name] = (folder_of(files[i]) / files[i].filename()).lexically_relative(folder);
  Json top = parse_transforms(transforms.text);
  for (Json& frame : top["frames"]) frame["depth_file_path"] = depth_of.at(photo_of(frame)).generic_string();
  OutputFile output(transforms.output, overwrite);
  constexpr int k_indent = 2;
  const std::string text = json_text(top, k_indent) + "\n";
  output.write(std::as_bytes(std::span(text)));
  output.commit();
}

}  // namespace alidade::tools
