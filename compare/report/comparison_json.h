// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/shown_text.h"
#include "compare/batch.h"
#include "compare/comparison.h"
#include "compare/verdict.h"

// How all JSON of comparisons is made. Keys keep their order.

namespace alidade::compare {

using Json = nlohmann::ordered_json;

/// A number, or the text for what JSON has no number for.
inline Json json_number(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0.0 ? "infinity" : "-infinity";
  return value;
}

// Parts that JSON for programs and that of pages have in common.

/// [{"threshold", "metric", "fails_if": "below" | "above", "limit", "value", "fails"}].
Json thresholds_json(const Verdict& verdict);

/// [{"left", "top", "right", "bottom", "pixels", "strongest", "mean", "at": [x, y]}], the largest first.
Json regions_json(const ChangeRegions& changes);

// How a comparison came to its figures: excluded pixels, settings of FLIP, fits and their results. For
// those who read a result without the command that made it.

struct HowLine {
  std::string name, text;
};

/// A line for every setting and finding of the run; of colours at least how FLIP was computed.
std::vector<HowLine> how_lines(const Comparison& comparison);

// Results for programs: {"metrics": {"rmse", "psnr", "ssim", "flip": {"mean", ...}}, "pass": true} and the
// further keys in docs/compare.md. JSON has no infinity and no NaN: they are the texts "infinity",
// "-infinity" and "nan".

/// One comparison, as text with indentation and a line end. `warnings`: thresholds that only warn.
std::string comparison_json(const Comparison& comparison, const Verdict& verdict,
                            const Verdict& warnings = {});

/// A batch: {"pairs": [...], "failed": N, "pass": false}, each pair with its name and the above or an
/// "error".
std::string batch_json(const std::vector<PairOutcome>& outcomes);

}  // namespace alidade::compare
