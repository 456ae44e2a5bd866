// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "cloud/laz/chunk_table.h"
#include "cloud/laz/laz_layout.h"

namespace alidade {

/// The chunk table of a LAZ file as it stands behind the chunks, which must be given in their order in the
/// file: how many bytes each takes and, for chunks of different sizes (LazLayout::chunk_size 0), how many
/// points. Requires sizes below 2^32 and less than 2^32 chunks.
std::vector<std::byte> encode_chunk_table(std::span<const LazChunk> chunks, const LazLayout& layout);

}  // namespace alidade
