// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/bounds.h"
#include "cloud/read_in_pieces.h"
#include "database/point_stream.h"

namespace alidade {

/// Points of some chunks that follow each other, as they are stored.
struct EncodedChunks {
  std::vector<LatticePosition> positions;
  std::vector<std::vector<std::byte>> blobs;  ///< the ids, then those of PointStream::blobs()
  std::vector<Bounds> boxes;                  ///< of each chunk
};

/// How points become chunks.
struct ChunkEncoding {
  std::uint32_t chunk_points = 1024;
  Lattice lattice{};
  std::vector<ValueBlob> blobs{};  ///< their sizes
  ColorSpread spread{};
};

/// Cost: linear.
EncodedChunks encode(const ChunkEncoding& encoding, const PickedPoints& points);

}  // namespace alidade
