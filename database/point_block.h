// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "database/value_blobs.h"

namespace alidade {

/// Some points of a cloud, in columns.
struct PointBlock {
  const LatticePosition* positions = nullptr;
  std::uint64_t first_id = 0;
  const std::uint32_t* rows = nullptr;  ///< the id of a point is first_id + its row; null: + its place
  std::vector<ValueBlob> blobs{};       ///< those without values stand for zeros
  std::vector<std::byte> memory{};      ///< where all that lies, if it is the block's own

  std::uint64_t id(std::uint32_t place) const { return first_id + (rows == nullptr ? place : rows[place]); }
};

/// Points of several blocks, in some order.
struct PickedPoints {
  struct Pick {
    const PointBlock* block;
    std::uint32_t place;  ///< in the block
  };
  std::vector<Pick> picks;
  std::vector<std::shared_ptr<const PointBlock>> blocks;  ///< that the picks point to
};

}  // namespace alidade
