// SPDX-License-Identifier: MIT
#pragma once

#include "compare/report/page_json.h"
#include "compare/verdict.h"

// What JSON for programs and that of pages have in common.

namespace alidade {

/// [{"threshold", "metric", "fails_if": "below" | "above", "limit", "value", "fails"}].
Json thresholds_json(const Verdict& verdict);

/// [{"left", "top", "right", "bottom", "pixels", "strongest", "mean", "at": [x, y]}], the largest first.
Json regions_json(const ChangeRegions& changes);

}  // namespace alidade
