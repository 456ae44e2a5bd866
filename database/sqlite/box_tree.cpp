// SPDX-License-Identifier: MIT
#include "database/sqlite/box_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace alidade {
namespace {

constexpr std::uint64_t k_fan_out = 64;
using Sides = std::array<double, 6>;

std::int64_t page_id(int level, std::uint64_t page) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(level) << 32 | page);
}

std::uint64_t pages_of(std::uint64_t boxes) {
  return (boxes + k_fan_out - 1) / k_fan_out;
}

}  // namespace

void write_box_tree(sqlite3* database, const std::string& table_name, std::vector<Bounds> boxes) {
  Statement row(database, "INSERT INTO " + table_name + " VALUES(?,?)");
  for (int level = 0; !boxes.empty(); ++level) {
    std::vector<Bounds> above;
    for (std::uint64_t page = 0; page < pages_of(boxes.size()); ++page) {
      const std::size_t begin = static_cast<std::size_t>(page * k_fan_out);
      const std::size_t end = std::min(boxes.size(), begin + static_cast<std::size_t>(k_fan_out));
      std::vector<Sides> sides;
      Bounds around;
      for (std::size_t i = begin; i < end; ++i) {
        const auto& [low, high] = boxes[i];
        sides.push_back({low.x, low.y, low.z, high.x, high.y, high.z});
        around.grow(boxes[i]);
      }
      row.bind(1, page_id(level, page)).bind(2, std::as_bytes(std::span(sides))).run();
      above.push_back(around);
    }
    boxes = above.size() > 1 ? std::move(above) : std::vector<Bounds>();
  }
}

BoxTree::BoxTree(sqlite3* database, const std::string& table_name, std::string cloud,
                 std::uint64_t chunk_count)
    : cloud_(std::move(cloud)), page_(database, "SELECT boxes FROM " + table_name + " WHERE id = ?") {
  for (std::uint64_t count = chunk_count; count > 0; count = count > k_fan_out ? pages_of(count) : 0)
    counts_.push_back(count);
}

std::vector<ChunkPlace> BoxTree::chunks(const std::function<bool(const Bounds&)>& wanted) {
  std::vector<ChunkPlace> found;
  if (!counts_.empty()) visit(static_cast<int>(counts_.size()) - 1, 0, wanted, found);
  return found;
}

void BoxTree::visit(int level, std::uint64_t page, const std::function<bool(const Bounds&)>& wanted,
                    std::vector<ChunkPlace>& found) {
  const std::uint64_t first = page * k_fan_out;
  const std::uint64_t count = std::min(k_fan_out, counts_[static_cast<std::size_t>(level)] - first);
  std::vector<Sides> boxes(static_cast<std::size_t>(count));
  page_.bind(1, page_id(level, page));
  const bool is_there = page_.step();
  const std::size_t size = is_there ? page_.bytes(0).size() : 0;
  const bool fits = size == boxes.size() * sizeof(Sides);
  if (fits) std::memcpy(boxes.data(), page_.bytes(0).data(), size);
  page_.reset();
  if (!fits) {
    throw Error({.file = cloud_,
                 .place = fmt::format("page {} of level {} of its boxes", page, level),
                 .problem = is_there ? "has another size than its boxes need" : "is not there",
                 .expected = fmt::format("{} bytes", boxes.size() * sizeof(Sides)),
                 .found = is_there ? fmt::format("{} bytes", size) : ""});
  }
  for (std::uint64_t i = 0; i < count; ++i) {
    const Sides& sides = boxes[static_cast<std::size_t>(i)];
    const Bounds box{{sides[0], sides[1], sides[2]}, {sides[3], sides[4], sides[5]}};
    if (!wanted(box)) continue;
    if (level == 0)
      found.push_back({first + i, box});
    else
      visit(level - 1, first + i, wanted, found);
  }
}

}  // namespace alidade
