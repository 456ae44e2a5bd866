// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "compare/batch.h"
#include "compare/comparison.h"
#include "compare/verdict.h"

// Results for programs: {"metrics": {"rmse", "psnr", "ssim", "flip": {"mean", ...}}, "pass": true} and what
// docs/compare.md says beside. JSON has no infinity and no NaN: they are the texts "infinity", "-infinity"
// and "nan".

namespace alidade {

/// One comparison, as text with indentation and a line end. `warnings`: thresholds that only warn.
std::string comparison_json(const Comparison& comparison, const Verdict& verdict,
                            const Verdict& warnings = {});

/// A batch: {"pairs": [...], "failed": N, "pass": false}, each pair with its name and the above or an
/// "error".
std::string batch_json(const std::vector<PairOutcome>& outcomes);

}  // namespace alidade
