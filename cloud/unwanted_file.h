// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "cloud/cloud_reader.h"
#include "cloud/read_cloud.h"

namespace alidade {

/// Why no point of a file is needed. By its box in a catalog, it lies outside of the region (`skipped`) or of
/// the box of a selection (`left_out`). `no`: it may be needed.
enum class Unwanted { no, skipped, left_out };

/// Whether a file is unwanted. Files whose lattice depends on all of their points are always needed, and so
/// is every file if damage is read over.
Unwanted what_is_unwanted(const CloudInput& input, const ReadOptions& options);

/// A reader of an unwanted file that does not open it: it has no points, and its survey is that of the
/// catalog. Requires an unwanted file.
std::unique_ptr<CloudReader> open_unwanted(const CloudInput& input, Unwanted unwanted);

}  // namespace alidade
