// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "cloud/cloud_reader.h"
#include "cloud/read_cloud.h"

namespace alidade {

/// Why nothing of a file is needed: by what a catalog states, it lies outside of the region, or of the box of a
/// selection. `no`: it may be needed.
enum class Unwanted { no, skipped, left_out };

/// Files whose lattice depends on all of their points are always needed, and so are damaged ones.
Unwanted what_is_unwanted(const CloudInput& input, const ReadOptions& options);

/// A reader of such a file that does not open it: it gives no points, and the survey says what the catalog states.
/// Requires a file that is unwanted.
std::unique_ptr<CloudReader> open_unwanted(const CloudInput& input, Unwanted unwanted);

}  // namespace alidade
