// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "base/scratch_file.h"

namespace alidade {

/// Brings records of one size into another order: `take` gets order[0], order[1] ... in pieces of whole
/// records. `order` has the number of each of them once. Memory: that of `scratch`, or some megabytes if
/// these are more. Records that fill more than half of that are written into scratch files once more, by the
/// part of the new order that they belong to: 128 parts of that size at a time. Cost: for each 128 parts two
/// passes over the records, and one over `order` for each quarter of that memory that its inverse takes.
/// Errors: those of scratch files and of `take`.
void reorder_records(const ScratchFile& records, std::size_t record_bytes,
                     std::span<const std::uint32_t> order, const ScratchSpace& scratch,
                     const std::function<void(std::span<const std::byte>)>& take);

}  // namespace alidade
