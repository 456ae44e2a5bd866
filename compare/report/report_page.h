// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "compare/comparison.h"
#include "compare/verdict.h"

namespace alidade::compare {

/// The comparison as one page of HTML that needs nothing else: no network, no other file, no server. Images
/// and maps to swipe, blink and zoom, regions of change, figures with thresholds, histograms and the metadata
/// of the files. Texts from files and their names are shown as text and never read as HTML. `warnings`:
/// thresholds that only warn. Requires comparison.images. Errors: what encoding images reports. Cost:
/// half a second to a second for 8 million pixels on two cores; memory: each map once more, 3 bytes per
/// pixel, and the page.
std::string report_page(const Comparison& comparison, const Verdict& verdict, image::ImagePacking packing,
                        const Verdict& warnings = {});

}  // namespace alidade::compare
