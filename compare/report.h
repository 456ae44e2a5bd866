// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "compare/comparison.h"
#include "compare/page_parts.h"
#include "compare/verdict.h"

namespace alidade {

/// The comparison as one page of HTML that needs nothing else: no network, no other file, no server. Pictures
/// and maps to swipe, blink and zoom, regions of change, figures with thresholds, histograms and what the
/// files say about themselves. Whatever comes from files and their names is shown as text and never read as
/// HTML. Requires comparison.pictures. Errors: what encoding pictures reports.
std::string report_page(const Comparison& comparison, const Verdict& verdict, PicturePacking packing);

}  // namespace alidade
