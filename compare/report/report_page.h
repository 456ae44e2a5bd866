// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "compare/comparison.h"
#include "compare/verdict.h"

namespace alidade::compare {

/// The comparison as a single HTML page that needs no network, other file or server: images and maps to
/// swipe, blink and zoom, regions of change, figures with thresholds, histograms and the metadata of the
/// files. Names of files and text from them are escaped. `packing` is the format of the images; `warnings`
/// are thresholds that do not affect the verdict. Requires comparison.images. Errors: those of
/// image::data_url(). Cost: half a second to a second for 8 million pixels on two cores. Memory: a copy of
/// each map, 3 bytes per pixel, and the page.
std::string report_page(const Comparison& comparison, const Verdict& verdict, image::ImagePacking packing,
                        const Verdict& warnings = {});

}  // namespace alidade::compare
