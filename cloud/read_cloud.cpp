// SPDX-License-Identifier: MIT
#include "cloud/read_cloud.h"

#include <algorithm>
#include <utility>

#include "base/parallel.h"
#include "cloud/catalog.h"
#include "cloud/cloud_reader.h"
#include "cloud/read_in_pieces.h"
#include "cloud/rows.h"

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

std::uint64_t StatedSize::bytes() const {
  return point_count * bytes_per_point(PointCloud(), attributes) + uncounted_bytes;
}

Bounds stated_box(const CloudInputs& inputs) {
  Bounds box;
  CloudInputs others;
  for (const CloudInput& input : inputs.inputs) {
    if (input.stated && !input.is_changed()) {
      box.grow(input.stated->box);
    } else {
      others.inputs.push_back(input);
    }
  }
  box.grow(stated_size(others).box);
  return box;
}

StatedSize stated_size(const CloudInputs& inputs) {
  std::vector<StatedSize> sizes(inputs.size());
  in_parallel(inputs.size(), 1, k_most_files_at_once, [&](std::size_t i) {
    if (what_is_unwanted(inputs.inputs[i], {}) != Unwanted::no) return;
    const auto reader = open_cloud(inputs.inputs[i], Damage::read_over);
    const FileFacts& facts = reader->facts();
    // Packed points rarely take less than a byte each.
    sizes[i] = {facts.box.value_or(Bounds()), std::min(facts.point_count.value_or(0), facts.bytes),
                facts.attributes, facts.point_count ? 0 : facts.bytes};
  });
  StatedSize all;
  for (const StatedSize& size : sizes) {
    all.box.grow(size.box);
    all.point_count += size.point_count;
    all.attributes = all.attributes | size.attributes;
    all.uncounted_bytes += size.uncounted_bytes;
  }
  return all;
}

}  // namespace alidade
