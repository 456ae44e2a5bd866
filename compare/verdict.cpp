// SPDX-License-Identifier: MIT
#include "compare/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/error.h"
#include "base/json.h"

namespace alidade {
namespace {

[[noreturn]] void fail(const std::string& problem, const std::string& found) {
  throw Error({.problem = problem,
               .expected = "NAME=LIMIT, NAME<LIMIT or NAME>LIMIT, as psnr<30",
               .found = "'" + found + "'"});
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(' ');
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(' ') - begin + 1);
}

const MetricKind& known_metric(std::string_view name) {
  if (const MetricKind* const found = find_metric(name)) return *found;
  std::vector<std::string_view> names;
  std::string all;
  for (const MetricKind& kind : metric_kinds()) {
    names.push_back(kind.name);
    all += (all.empty() ? "" : ", ") + std::string(kind.name);
  }
  const std::string_view nearest = nearest_word(name, names);
  throw Error({.problem = fmt::format("unknown figure '{}' in a threshold", name),
               .expected = nearest.empty() ? "one of " + all
                                           : fmt::format("'{}' perhaps, or one of {}", nearest, all)});
}

double limit_of(std::string_view text, const std::string& whole) {
  double limit = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), limit);
  if (error != std::errc{} || end != text.data() + text.size() || std::isnan(limit))
    fail("a threshold without a number", whole);
  return limit;
}

Threshold parse_threshold(const std::string& text) {
  const std::size_t sign = text.find_first_of("=<>");
  if (sign == std::string::npos) fail("not a threshold", text);
  const std::string_view view = text;
  const std::string_view name = trimmed(view.substr(0, sign));
  if (name.empty()) fail("a threshold without a name", text);
  Threshold threshold{.metric = std::string(known_metric(name).name),
                      .limit = limit_of(trimmed(view.substr(sign + 1)), text)};
  if (text[sign] != '=') threshold.kind = text[sign] == '<' ? LimitKind::below : LimitKind::above;
  return threshold;
}

JudgedThreshold judged(const Threshold& threshold, double value, Better better) {
  const bool below =
      threshold.kind == LimitKind::below || (threshold.kind == LimitKind::worse && better == Better::higher);
  const bool fails = std::isnan(value) || (below ? value < threshold.limit : value > threshold.limit);
  return {threshold, value, below, fails};
}

}  // namespace

std::vector<Threshold> parse_thresholds(const std::string& text) {
  std::vector<Threshold> thresholds;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    thresholds.push_back(parse_threshold(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return thresholds;
}

std::string to_text(const Threshold& threshold) {
  constexpr char k_signs[] = {'=', '<', '>'};
  return fmt::format("{}{}{}", threshold.metric, k_signs[static_cast<std::size_t>(threshold.kind)],
                     threshold.limit);
}

bool Verdict::pass() const {
  return std::ranges::none_of(judged, &JudgedThreshold::fails);
}

Verdict judge(const Comparison& comparison, const std::vector<Threshold>& thresholds) {
  Verdict verdict;
  for (const Threshold& threshold : thresholds) {
    const MetricKind& kind = known_metric(threshold.metric);
    const std::optional<double> value = kind.value(comparison);
    if (!value) {
      throw Error({.file = comparison.test.file.string(),
                   .problem = fmt::format("a threshold on '{}', which these pictures do not have", kind.name),
                   .expected = std::string(kind.note)});
    }
    verdict.judged.push_back(judged(threshold, *value, kind.better));
  }
  return verdict;
}

}  // namespace alidade
