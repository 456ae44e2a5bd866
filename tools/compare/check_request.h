// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "compare/pair_list.h"
#include "tools/compare/compare_options.h"

// What can be wrong with a request before any pixel is looked at.

namespace alidade {

/// Whether many pairs of pictures are asked for.
bool is_batch(const CompareRequest& request);

/// Errors that need no picture: words missing or too many, wishes that do not go together, outputs that
/// cannot be written or would replace an input.
void check_request(const CompareRequest& request);

/// The same for the pictures of a batch. Errors: the summary would replace one of them.
void check_pairs(const CompareRequest& request, const std::vector<ImagePair>& pairs);

}  // namespace alidade
