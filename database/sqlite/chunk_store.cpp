// SPDX-License-Identifier: MIT
#include "database/sqlite/chunk_store.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <utility>

#include "cloud/lattice.h"

namespace alidade::database {
namespace {

constexpr std::uint64_t k_fan_out = 64;
constexpr double k_infinity = std::numeric_limits<double>::infinity();
const Bounds k_everywhere{glm::dvec3(-k_infinity), glm::dvec3(k_infinity)};
using Sides = std::array<double, 6>;

std::int64_t page_id(int level, std::uint64_t page) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(level) << 32 | page);
}

std::uint64_t pages_of(std::uint64_t boxes) {
  return (boxes + k_fan_out - 1) / k_fan_out;
}

/// False also for invalid boxes.
bool lies_inside(const Bounds& box, const Bounds& around) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(around.min[axis] <= box.min[axis] && box.min[axis] <= box.max[axis] &&
          box.max[axis] <= around.max[axis]))
      return false;
  }
  return true;
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
      row.run_with(page_id(level, page), std::as_bytes(std::span(sides)));
      above.push_back(around);
    }
    boxes = above.size() > 1 ? std::move(above) : std::vector<Bounds>();
  }
}

BoxTree::BoxTree(sqlite3* database, const std::string& schema, const std::string& table,
                 std::uint64_t chunk_count)
    : file_(file_of(database, schema)),
      table_(table),
      page_(database, "SELECT boxes FROM " + part_name(schema, table, "bounds") + " WHERE id = ?",
            Readable::plain_tables, schema) {
  for (std::uint64_t count = chunk_count; count > 0; count = count > k_fan_out ? pages_of(count) : 0)
    counts_.push_back(count);
}

std::vector<ChunkLocation> BoxTree::chunks(const std::function<bool(const Bounds&)>& wanted) {
  std::vector<ChunkLocation> found;
  if (!counts_.empty()) visit(static_cast<int>(counts_.size()) - 1, 0, k_everywhere, wanted, found);
  return found;
}

std::optional<ChunkLocation> BoxTree::chunk(std::uint64_t id) {
  if (counts_.empty() || id >= counts_[0]) return std::nullopt;
  return ChunkLocation{id,
                       read_page(0, id / k_fan_out, k_everywhere)[static_cast<std::size_t>(id % k_fan_out)]};
}

std::vector<Bounds> BoxTree::read_page(int level, std::uint64_t page, const Bounds& around) {
  const std::uint64_t count =
      std::min(k_fan_out, counts_[static_cast<std::size_t>(level)] - page * k_fan_out);
  std::vector<Sides> pages(static_cast<std::size_t>(count));
  page_.bind(1, page_id(level, page));
  const bool is_there = page_.step();
  const std::size_t size = is_there ? page_.bytes(0).size() : 0;
  const bool fits = size == pages.size() * sizeof(Sides);
  if (fits) std::memcpy(pages.data(), page_.bytes(0).data(), size);
  page_.reset();
  const auto reject = [&](std::string problem, std::string expected, std::string found) {
    reject_stored({file_, fmt::format("{}, page {} of level {} of its boxes", table_, page, level),
                   std::move(problem), std::move(expected), std::move(found)});
  };
  if (!fits) {
    reject(is_there ? "wrong size of the boxes" : "missing boxes",
           fmt::format("{} bytes", pages.size() * sizeof(Sides)),
           is_there ? fmt::format("{} bytes", size) : "");
  }
  std::vector<Bounds> boxes;
  for (const auto& [x, y, z, to_x, to_y, to_z] : pages) {
    boxes.push_back({{x, y, z}, {to_x, to_y, to_z}});
    if (lies_inside(boxes.back(), around)) continue;
    reject("invalid box", "minimum and maximum of x, y, z inside the box of the page",
           fmt::format("{}, {}, {} to {}, {}, {}", x, y, z, to_x, to_y, to_z));
  }
  return boxes;
}

void BoxTree::visit(int level, std::uint64_t page, const Bounds& around,
                    const std::function<bool(const Bounds&)>& wanted, std::vector<ChunkLocation>& found) {
  std::uint64_t number = page * k_fan_out;
  for (const Bounds& box : read_page(level, page, around)) {
    const std::uint64_t below = number++;
    if (!wanted(box)) continue;
    if (level == 0)
      found.push_back({below, box});
    else
      visit(level - 1, below, box, wanted, found);
  }
}

ChunkStore::ChunkStore(sqlite3* database, const std::string& schema, const std::string& table,
                       const CloudSchema& cloud)
    : file_(file_of(database, schema)),
      table_(table),
      lattice_(cloud.lattice),
      boxes_(database, schema, table, cloud.chunk_count),
      positions_(database,
                 "SELECT points, positions FROM " + part_name(schema, table, "chunk") + " WHERE id = ?",
                 Readable::plain_tables, schema),
      values_(database, "SELECT data FROM " + part_name(schema, table, "value") + " WHERE id = ?",
              Readable::plain_tables, schema) {}

void ChunkStore::reject(std::uint64_t chunk, std::string problem, std::string expected,
                        std::string found) const {
  reject_stored({file_, fmt::format("{}, chunk {}", table_, chunk), std::move(problem), std::move(expected),
                 std::move(found)});
}

std::vector<ChunkLocation> ChunkStore::chunks(const PointFilter& filter, std::optional<std::uint64_t> only) {
  const auto wanted = [&](const Bounds& box) { return may_hold(filter, box); };
  if (!only) return boxes_.chunks(wanted);
  const std::optional<ChunkLocation> location = boxes_.chunk(*only);
  return location && wanted(location->box) ? std::vector{*location} : std::vector<ChunkLocation>();
}

std::shared_ptr<StoredChunk> ChunkStore::read(const ChunkLocation& location) {
  const std::uint64_t id = location.id;
  positions_.bind(1, static_cast<std::int64_t>(id));
  if (!positions_.step()) {
    positions_.reset();
    reject(id, "missing chunk", "a row in the table of chunks", "");
  }
  const std::int64_t count = positions_.whole(0);
  const std::span<const std::byte> bytes = positions_.bytes(1);
  auto chunk = std::make_shared<StoredChunk>();
  chunk->id = id;
  const std::size_t size = bytes.size();
  const bool fits = size % sizeof(LatticePosition) == 0 &&
                    static_cast<std::int64_t>(size / sizeof(LatticePosition)) == count;
  if (fits && size > 0) {
    chunk->positions.resize(size / sizeof(LatticePosition));
    std::memcpy(chunk->positions.data(), bytes.data(), size);
  }
  positions_.reset();
  if (!fits) {
    reject(id, "wrong size of the positions",
           fmt::format("{} bytes for each of {} points", sizeof(LatticePosition), count),
           fmt::format("{} bytes", size));
  }
  LatticeExtent extent;
  for (const LatticePosition& position : chunk->positions) extent.grow(position);
  if (!chunk->positions.empty() && (to_world(lattice_, extent.low) != location.box.min ||
                                    to_world(lattice_, extent.high) != location.box.max))
    reject(id, "the points do not match their box", "the bounds of the points", "");
  return chunk;
}

const std::byte* ChunkStore::bytes(StoredChunk& chunk, const StoredColumn& column, std::size_t row) {
  const auto blob = static_cast<std::size_t>(column.blob);
  const auto size = static_cast<std::size_t>(column.size);
  if (chunk.blobs.size() <= blob) chunk.blobs.resize(blob + 1);
  if (!chunk.blobs[blob]) {
    values_.bind(1, value_id(column.blob, chunk.id));
    const bool is_there = values_.step();
    const std::span<const std::byte> stored = is_there ? values_.bytes(0) : std::span<const std::byte>();
    chunk.blobs[blob].emplace(stored.begin(), stored.end());
    values_.reset();
  }
  // Checked at each call, since columns may disagree about the size of the blob they share.
  if (chunk.blobs[blob]->size() != size * chunk.positions.size()) {
    reject(chunk.id, fmt::format("wrong size of the values of {}", column.name),
           fmt::format("{} bytes for each of {} points", size, chunk.positions.size()),
           fmt::format("{} bytes", chunk.blobs[blob]->size()));
  }
  return chunk.blobs[blob]->data() + row * size + static_cast<std::size_t>(column.byte);
}

}  // namespace alidade::database
