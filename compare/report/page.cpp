// SPDX-License-Identifier: MIT
#include "compare/report/page.h"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>

#include "base/shown_text.h"
#include "compare/report/comparison_json.h"

namespace alidade::compare {

std::string fill_page(std::string_view page,
                      const std::vector<std::pair<std::string_view, std::string_view>>& values) {
  std::string filled;
  std::size_t begin = 0;
  for (std::size_t open = page.find("{{"); open != std::string_view::npos; open = page.find("{{", begin)) {
    const std::size_t close = page.find("}}", open);
    const std::string_view name = page.substr(open + 2, close - open - 2);
    const auto value = std::ranges::find(values, name, &std::pair<std::string_view, std::string_view>::first);
    assert(close != std::string_view::npos && value != values.end());
    filled.append(page.substr(begin, open - begin)).append(value->second);
    begin = close + 2;
  }
  return filled.append(page.substr(begin));
}

std::string html_text(std::string_view text) {
  constexpr std::string_view k_special = "&<>\"'";
  constexpr std::string_view k_escapes[] = {"&amp;", "&lt;", "&gt;", "&quot;", "&#39;"};
  std::string escaped;
  for (const char& c : line_text(text)) {
    const std::size_t special = k_special.find(c);
    escaped += special == std::string_view::npos ? std::string_view(&c, 1) : k_escapes[special];
  }
  return escaped;
}

std::string script_json(std::string_view json) {
  std::string shown;
  for (std::size_t i = 0; i < json.size(); ++i) {
    if (json[i] == '<') {
      shown += "\\u003c";
    } else {
      shown += json[i];
      if (json[i] != '\\') continue;
      // The escape of a character that browsers interpret becomes text.
      if (json[i + 1] == 'u') shown += '\\';
      shown += json[++i];
    }
  }
  return shown;
}

namespace {

constexpr std::string_view k_figures[] = {"flip", "ssim", "psnr", "rmse", "depth_mean"};

std::string failures_of(const PairOutcome& outcome) {
  std::string text;
  for (const JudgedThreshold& judged : outcome.verdict.judged)
    if (judged.fails)
      text += fmt::format("{}{} is not kept", text.empty() ? "" : "; ", to_text(judged.threshold));
  return text;
}

/// The address of a file from a page in `folder`: bytes that mean something in addresses are escaped.
std::string address(const std::filesystem::path& file, const std::filesystem::path& folder) {
  constexpr std::string_view k_plain = "-_.~/";
  std::string text;
  const std::filesystem::path base =
      std::filesystem::absolute(folder.empty() ? "." : folder).lexically_normal();
  for (const char c :
       std::filesystem::absolute(file).lexically_normal().lexically_relative(base).generic_string()) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                          k_plain.find(c) != std::string_view::npos;
    text += is_plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return text;
}

Json pair_json(const PairOutcome& outcome, const std::filesystem::path& folder) {
  Json metrics = Json::object();
  if (outcome.comparison) {
    for (const Metric& metric : metrics_of(*outcome.comparison))
      if (std::ranges::find(k_figures, metric.kind->name) != std::end(k_figures))
        metrics[std::string(metric.kind->name)] = json_number(metric.value);
  }
  return {{"name", outcome.pair.name},
          {"pass", outcome.pass()},
          {"error", outcome.error},
          {"failed", failures_of(outcome)},
          {"metrics", metrics},
          {"pictures", outcome.thumbnails},
          {"report", outcome.report.empty() ? "" : address(outcome.report, folder)}};
}

}  // namespace

std::string summary_page(const std::vector<PairOutcome>& outcomes, const std::string& reference,
                         const std::string& test, const std::filesystem::path& page) {
  Json pairs = Json::array(), labels = Json::object();
  for (const PairOutcome& outcome : outcomes) pairs.push_back(pair_json(outcome, page.parent_path()));
  for (const std::string_view name : k_figures) {
    const MetricKind& kind = *find_metric(name);
    labels[std::string(name)] = {{"label", full_label(kind)}, {"unit", kind.unit}};
  }
  const bool is_judged = std::ranges::any_of(
      outcomes, [](const PairOutcome& outcome) { return !outcome.verdict.judged.empty(); });
  const Json json{{"generator", "Alidade " ALIDADE_VERSION},
                  {"reference", reference},
                  {"test", test},
                  {"remarks", Json::array()},
                  {"tiles", k_figures},
                  {"labels", labels},
                  {"judged", is_judged},
                  {"pairs", pairs}};
  const std::string data = script_json(json_text(json, -1));
  const std::string title = html_text(test + " against " + reference);
  return fill_page(k_summary_html, {{"title", title},
                                    {"style", k_style_css},
                                    {"data", data},
                                    {"script", std::string(k_page_js) + std::string(k_summary_js)}});
}

}  // namespace alidade::compare
