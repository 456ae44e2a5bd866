// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compare/batch.h"

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

/// The batch as one page, worst first, with small images, and with links to the reports of pairs, which are
/// addressed from the folder of `page`. `reference` and `test` are the names of the two sides for people.
std::string summary_page(const std::vector<PairOutcome>& outcomes, const std::string& reference,
                         const std::string& test, const std::filesystem::path& page);

}  // namespace alidade::compare
