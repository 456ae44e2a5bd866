// SPDX-License-Identifier: MIT
#include "cloud/read_cloud.h"

#include <utility>
#include <vector>

#include "base/parallel.h"
#include "cloud/cloud_inputs.h"
#include "cloud/joined_files.h"
#include "cloud/read_in_pieces.h"

namespace alidade {

PointCloud join_files(std::vector<InputFile> files, const ReadOptions& options) {
  PiecewiseCloud whole = join_in_pieces(std::move(files), options, {});
  apply(whole.spread, whole.rest);
  return std::move(whole.rest);
}

PiecewiseCloud read_in_pieces(std::span<const std::filesystem::path> paths, const ReadOptions& options,
                              const CloudPieces& pieces) {
  const std::vector<std::filesystem::path> names = expand_cloud_files(paths);
  std::vector<InputFile> files;
  for (const std::filesystem::path& name : names) files.emplace_back(cloud_input(name)).rest();
  PiecewiseCloud whole = join_in_pieces(std::move(files), options, pieces);
  warn_of_twins(names, whole.rest);
  return whole;
}

PointCloud read_cloud(std::span<const std::filesystem::path> paths, const ReadOptions& options) {
  PiecewiseCloud whole = read_in_pieces(paths, options, {});
  apply(whole.spread, whole.rest);
  return std::move(whole.rest);
}

PointCloud read_cloud(const std::filesystem::path& file, const ReadOptions& options) {
  return read_cloud(std::span(&file, 1), options);
}

Bounds stated_box(std::span<const std::filesystem::path> paths) {
  const std::vector<std::filesystem::path> files = expand_cloud_files(paths);
  std::vector<Bounds> boxes(files.size());
  in_turns(files.size(), k_most_files_at_once, [&](std::size_t i) {
    boxes[i] = open_cloud(cloud_input(files[i]), Damage::read_over)->facts().box.value_or(Bounds());
  });
  Bounds all;
  for (const Bounds& box : boxes) all.grow(box);
  return all;
}

}  // namespace alidade
