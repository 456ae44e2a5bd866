// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "compare/batch.h"
#include "compare/comparison.h"
#include "compare/verdict.h"

namespace alidade {

/// The table that people read on a terminal.
std::string comparison_text(const Comparison& comparison, const Verdict& verdict);

/// A line per pair, worst first, and one that sums up.
std::string batch_text(const std::vector<PairOutcome>& outcomes);

/// "flip=0.05: 0.08", for those that fail.
std::vector<std::string> failures_of(const Verdict& verdict);

}  // namespace alidade
