// SPDX-License-Identifier: MIT
#include "octree/copc_tiles.h"

#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "base/error.h"
#include "base/morton.h"
#include "cloud/catalog.h"
#include "cloud/cloud_reader.h"
#include "cloud/crs.h"

namespace alidade {

struct CopcTiles::Slot {
  std::mutex opening;     ///< held by the thread that opens the file
  bool was_open = false;  ///< belongs to mutex_
};

CopcTiles::Tile::Tile(const CloudInput& input, const CopcCache::Options& options, bool rests)
    : file(input.file(), rests, &input), cache(file, options), kept_in_all(*options.kept_in_all) {
  // Measured with small files: most of it are the tables of the decoder. Nodes take their own size and that
  // of their slots.
  constexpr std::size_t k_file_bytes = 160 << 10, k_node_bytes = 160;
  byte_count = k_file_bytes + k_node_bytes * file.hierarchy().nodes.size();
  kept_in_all += byte_count;
}

CopcTiles::Tile::~Tile() {
  kept_in_all -= byte_count;
}

CopcTiles::CopcTiles(const CloudInputs& inputs, const CopcCache::Options& options)
    : inputs_(inputs), options_(options), slots_(std::make_unique<Slot[]>(inputs.size())) {
  options_.kept_in_all = &kept_bytes_;
  std::vector<std::shared_ptr<Tile>> unstated(size());
  std::vector<Bounds> boxes(size());
  first_rows_.assign(size() + 1, 0);
  for (std::uint32_t i = 0; i < size(); ++i) {
    const CloudInput& input = inputs_.inputs[i];
    const auto& stated = input.stated;
    is_any_remote_ = is_any_remote_ || (!input.memory && is_remote_name(input.name.string()));
    if (!stated) unstated[i] = open(i);
    const std::uint64_t count = stated ? stated->point_count : unstated[i]->file.header().point_count;
    first_rows_[i + 1] = first_rows_[i] + count;
    const CopcHierarchy* const hierarchy = stated ? nullptr : &unstated[i]->file.hierarchy();
    if (stated) {
      boxes[i] = stated->box;
    } else if (!hierarchy->nodes.empty()) {
      boxes[i] = unstated[i]->file.bounds(hierarchy->nodes.front());
    }
  }
  std::uint32_t first = 0;
  while (first + 1 < size() && first_rows_[first + 1] == 0) ++first;
  if (!unstated[first]) unstated[first] = open(first);
  lattice_ = unstated[first]->file.header().lattice;
  crs_ = unstated[first]->file.records().crs;
  first_name_ = unstated[first]->file.name();
  for (std::uint32_t i = 0; i < size(); ++i) {
    if (!unstated[i]) continue;
    std::ranges::copy(unstated[i]->file.warnings(), std::back_inserter(warnings_));
    join(i, std::move(unstated[i]));
  }
  build_boxes(boxes);
}

CopcTiles::~CopcTiles() = default;

void CopcTiles::build_boxes(const std::vector<Bounds>& boxes) {
  Bounds all;
  for (std::uint32_t i = 0; i < size(); ++i) {
    if (first_rows_[i + 1] == first_rows_[i]) continue;
    all.grow(boxes[i]);
    order_.push_back(i);
  }
  if (order_.empty()) return;
  const double longest = std::max({all.size().x, all.size().y, all.size().z, 1e-300});
  std::vector<std::uint64_t> keys(size());
  for (const std::uint32_t i : order_) {
    const glm::dvec3 cell = (boxes[i].center() - all.min) * (((1 << k_morton_bits) - 1) / longest);
    keys[i] = morton_key(static_cast<std::uint32_t>(cell.x), static_cast<std::uint32_t>(cell.y),
                         static_cast<std::uint32_t>(cell.z));
  }
  std::ranges::stable_sort(order_, {}, [&](std::uint32_t i) { return keys[i]; });
  std::vector<Bounds>& lowest = boxes_.emplace_back();
  for (const std::uint32_t i : order_) lowest.push_back(boxes[i]);
  while (boxes_.back().size() > 1) {
    std::vector<Bounds> above((boxes_.back().size() + k_fan_out - 1) / k_fan_out);
    for (std::size_t i = 0; i < boxes_.back().size(); ++i) above[i / k_fan_out].grow(boxes_.back()[i]);
    boxes_.push_back(std::move(above));
  }
}

std::shared_ptr<CopcTiles::Tile> CopcTiles::open(std::uint32_t number) const {
  const CloudInput& input = inputs_.inputs[number];
  CopcCache::Options options = options_;
  if (input.stated) options.stated_box = input.stated->box;
  auto tile = std::make_shared<Tile>(input, options, size() > 1);
  const LasHeader& header = tile->file.header();
  const bool has_box = widened_header_box(header.bounds, header.lattice).has_value();
  check_stated(input, header.point_count, has_box ? std::optional(header.bounds) : std::nullopt);
  return tile;
}

std::shared_ptr<const CopcTiles::Tile> CopcTiles::join(std::uint32_t number,
                                                       std::shared_ptr<Tile> tile) const {
  const Crs& crs = tile->file.records().crs;
  if (!crs.empty() && !crs_.empty() && compare_crs(crs, crs_) == CrsAgreement::different)
    throw file_error(tile->file.name(), "the coordinate reference system differs from that of " + first_name_,
                     crs_name(crs_) + " (alidade convert --reproject SYSTEM brings files to one)",
                     crs_name(crs));
  const Lattice& own = tile->file.header().lattice;
  if (tile->file.header().point_count > 0 && !steps_between(own, lattice_))
    throw file_error(tile->file.name(), "the lattice differs from that of " + first_name_,
                     "--load, which reads all files and joins them on one lattice",
                     fmt::format("scale {}, {}, {}", own.scale.x, own.scale.y, own.scale.z));
  tile->tree.emplace(tile->cache, lattice_, first_rows_[number]);
  const auto& nodes = tile->file.hierarchy().nodes;
  const std::lock_guard lock(mutex_);
  if (!std::exchange(slots_[number].was_open, true)) {
    ++work_.files_opened;
    work_.chunk_count += static_cast<std::uint64_t>(
        std::ranges::count_if(nodes, [](const CopcNode& node) { return node.chunk.point_count > 0; }));
  }
  return open_.add(number, std::move(tile));
}

std::shared_ptr<const CopcTiles::Tile> CopcTiles::find(std::uint32_t number) const {
  const std::lock_guard lock(mutex_);
  const auto* const tile = open_.find(number);
  return tile != nullptr ? *tile : nullptr;
}

void CopcTiles::make_room() const {
  while (kept_bytes_ > options_.byte_count) {
    std::shared_ptr<const Tile> oldest;  // given back without the lock
    const std::lock_guard lock(mutex_);
    if (open_.size() < 2) return;
    oldest = open_.take_oldest();
    work_.reads += oldest->cache.reads();
  }
}

std::shared_ptr<const CopcTiles::Tile> CopcTiles::tile(std::uint32_t number) const {
  make_room();
  if (auto tile = find(number)) return tile;
  const std::lock_guard opening(slots_[number].opening);
  if (auto tile = find(number)) return tile;
  return join(number, open(number));
}

CopcTiles::Work CopcTiles::work() const {
  const std::lock_guard lock(mutex_);
  Work work = work_;
  for (const auto& [number, tile] : open_.entries()) work.reads += tile->cache.reads();
  return work;
}

}  // namespace alidade
