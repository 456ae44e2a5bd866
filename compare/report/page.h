// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compare/comparison.h"
#include "compare/verdict.h"

namespace alidade::compare {

// The files of compare/report as texts, through compare/report/page_parts.cpp.in.
extern const std::string_view k_report_html, k_summary_html, k_style_css, k_page_js, k_tables_js, k_viewer_js,
    k_summary_js;

/// The template with every {{name}} replaced by the value of that name; values are not expanded again.
/// Requires a value for every name of the template.
std::string fill_page(std::string_view page,
                      const std::vector<std::pair<std::string_view, std::string_view>>& values);

/// line_text() escaped for HTML and for its quoted attributes.
std::string html_text(std::string_view text);

/// The result of json_text() escaped for a script element: no "</script>" can end it early. Characters that
/// json_text() escaped by their number are shown as these escapes.
std::string script_json(std::string_view json);

/// Writes a page, completely or not at all. Errors: those of OutputFile.
void write_page(const std::string& page, const std::filesystem::path& file, bool overwrite);

/// The comparison as one page of HTML that needs nothing else: no network, no other file, no server. Images
/// and maps to swipe, blink and zoom, regions of change, figures with thresholds, histograms and the metadata
/// of the files. Texts from files and their names are shown as text and never read as HTML. `warnings`:
/// thresholds that only warn. Requires comparison.images. Errors: what encoding images reports. Cost:
/// half a second to a second for 8 million pixels on two cores; memory: each map once more, 3 bytes per
/// pixel, and the page.
std::string report_page(const Comparison& comparison, const Verdict& verdict, image::ImagePacking packing,
                        const Verdict& warnings = {});

}  // namespace alidade::compare
