// SPDX-License-Identifier: MIT
#include "renderer/cloud_in_view.h"

#include <algorithm>

#include "cloud/cloud_inputs.h"
#include "image/color_points.h"
#include "renderer/index_cloud.h"
#include "renderer/load_cloud.h"
#include "renderer/nodes_in_view.h"

namespace alidade {

std::vector<std::unique_ptr<CopcFile>> open_copc_cloud(const CloudSettings& settings) {
  constexpr std::size_t k_most_files = 256;  // all of which stay open
  const std::vector<std::filesystem::path> paths = expand_cloud_files(settings.files);
  std::vector<std::unique_ptr<CopcFile>> files;
  if (paths.size() > k_most_files) return files;
  for (const std::filesystem::path& path : paths) {
    InputFile file = cloud_input(path);
    if (!is_copc(file)) return {};
    files.push_back(std::make_unique<CopcFile>(std::move(file)));
  }
  return files;
}

LoadedCloud load_coarse_cloud(const CloudSettings& wanted,
                              const std::vector<std::unique_ptr<CopcFile>>& files, const Camera* camera,
                              std::uint64_t most_points, const Progress& progress) {
  CloudSettings settings = wanted;
  settings.files.clear();
  double widest = 0.0;
  for (const auto& file : files) {
    settings.files.emplace_back(file->name());
    widest = std::max(widest, file->info().spacing);
  }
  settings.radius.reset();
  settings.adapted_radius = AdaptedRadius{.max = widest};
  const AttributeSet attributes =
      check_color_of_files(settings.color, settings.files, Damage::refuse, settings.files.front().string());
  const std::vector<ChosenNodes> nodes = nodes_in_view(files, camera, most_points);
  LoadedCloud loaded = index_cloud(read_copc_nodes(nodes, {.attributes = attributes_for(settings.color),
                                                           .color_depth = settings.color_depth,
                                                           .progress = progress}),
                                   attributes, settings);
  choose_radius(settings, loaded);
  return loaded;
}

}  // namespace alidade
