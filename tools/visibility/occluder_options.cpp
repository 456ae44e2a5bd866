// SPDX-License-Identifier: MIT
#include "tools/visibility/occluder_options.h"

#include "tools/options.h"
#include "tools/split_list.h"

namespace alidade {
namespace {

constexpr const char* k_group = "What blocks";

/// "7,18"; "none" for no class.
std::bitset<256> parse_classes(const std::string& text) {
  std::bitset<256> classes;
  if (text == "none") return classes;
  for (const std::string& word : split_list(text))
    classes.set(static_cast<std::size_t>(parse_count(word, 0, 255)));
  return classes;
}

}  // namespace

void add_occluder_options(CLI::App& command, OccluderRequest& request) {
  add_choice<OccluderShape>(
      command, "--occluder",
      "what a point blocks with (default auto): a disc on its surface, a sphere, or discs where there is a "
      "surface and spheres elsewhere (foliage, wires)",
      request.shape,
      {{"auto", OccluderShape::automatic}, {"disc", OccluderShape::disc}, {"sphere", OccluderShape::sphere}})
      ->group(k_group);
  add_value(
      command, "--radius", "R",
      "of discs and spheres, in metres (default: each point's own, from the distance to its neighbours)",
      [&request](const std::string& text) { request.radius = parse_number(text, 1e-6, 1e6); })
      ->group(k_group);
  add_value(command, "--transparency", "K",
            "a line is blocked from so many separate crossings on (default: 1); more sees through foliage",
            [&request](const std::string& text) {
              request.transparency = static_cast<int>(parse_count(text, 1, 1000));
            })
      ->group(k_group);
  add_value(command, "--ignore-classes", "LIST|none",
            "points of these classes block nothing (default: 7,18, which are noise)",
            [&request](const std::string& text) { request.ignored_classes = parse_classes(text); })
      ->group(k_group);
}

}  // namespace alidade
