// SPDX-License-Identifier: MIT
#include "cloud/read_cloud.h"

#include <utility>
#include <vector>

#include "base/parallel.h"
#include "cloud/read_in_pieces.h"

namespace alidade {

PointCloud read_cloud(const CloudInputs& inputs, const ReadOptions& options) {
  PiecewiseCloud whole = read_in_pieces(inputs, options, {});
  apply(whole.spread, whole.rest);
  return std::move(whole.rest);
}

PointCloud read_cloud(std::span<const std::filesystem::path> files, const ReadOptions& options) {
  return read_cloud(resolve_clouds(files), options);
}

PointCloud read_cloud(const std::filesystem::path& file, const ReadOptions& options) {
  return read_cloud(std::span(&file, 1), options);
}

Bounds stated_box(const CloudInputs& inputs) {
  std::vector<Bounds> boxes(inputs.size());
  in_turns(inputs.size(), k_most_files_at_once, [&](std::size_t i) {
    boxes[i] = open_cloud(inputs.inputs[i], Damage::read_over)->facts().box.value_or(Bounds());
  });
  Bounds all;
  for (const Bounds& box : boxes) all.grow(box);
  return all;
}

}  // namespace alidade
