// SPDX-License-Identifier: MIT
#include "tools/compare/compare_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "compare/report/comparison_json.h"

namespace alidade {
namespace {

std::string facts_text(const char* side, const PictureFacts& facts) {
  return fmt::format("{:<10} {}  {} x {}, {}\n", side, facts.file.string(), facts.width, facts.height,
                     facts.encoding == ColorEncoding::display ? "display" : "linear light");
}

std::string regions_text(const ChangeRegions& changes) {
  constexpr std::size_t k_most_lines = 10;
  std::string text = fmt::format("\nRegions of change: {}, with {} of {} changed pixels\n",
                                 changes.regions.size(), changes.listed_pixels, changes.changed_pixels);
  for (std::size_t i = 0; i < std::min(k_most_lines, changes.regions.size()); ++i) {
    const ChangeRegion& region = changes.regions[i];
    text += fmt::format("  {:>3}  {} pixels in {},{},{},{}, strongest {:.4g} at {},{}\n", i + 1,
                        region.pixels, region.left, region.top, region.right, region.bottom, region.strongest,
                        region.x, region.y);
  }
  if (changes.regions.size() > k_most_lines)
    text += fmt::format("  and {} more, see --json or --report\n", changes.regions.size() - k_most_lines);
  return text;
}

}  // namespace

std::vector<std::string> failures_of(const Verdict& verdict) {
  std::vector<std::string> failures;
  for (const JudgedThreshold& judged : verdict.judged)
    if (judged.fails) failures.push_back(fmt::format("{}: {:.6g}", to_text(judged.threshold), judged.value));
  return failures;
}

std::string comparison_text(const Comparison& comparison, const Verdict& verdict) {
  std::string text = facts_text("reference", comparison.reference) + facts_text("test", comparison.test);
  text += fmt::format("{:<10} {} of {} pixels", "counted", comparison.counted, comparison.pixels);
  text += comparison.excluded > 0 ? fmt::format(", {} of them without finite colours\n", comparison.excluded)
                                  : "\n";
  std::string_view group;
  for (const Metric& metric : metrics_of(comparison)) {
    if (metric.kind->group != group) {
      group = metric.kind->group;
      text += fmt::format("\n{}\n", group);
    }
    text += fmt::format("  {:<18} {:>12.6g} {:<4} {}\n", metric.kind->name, metric.value, metric.kind->unit,
                        metric.kind->label);
    if (metric.place)
      text.insert(text.size() - 1, fmt::format(" at {},{}", metric.place->x, metric.place->y));
  }
  const std::vector<HowLine> how = how_lines(comparison);
  if (!how.empty()) text += "\nHow it was compared\n";
  for (const HowLine& line : how) text += fmt::format("  {:<18} {}\n", line.name, line.text);
  if (comparison.changes) text += regions_text(*comparison.changes);
  if (verdict.judged.empty()) return text;
  text += "\nThresholds\n";
  for (const JudgedThreshold& judged : verdict.judged)
    text += fmt::format("  {:<18} {:>12.6g}      {}\n", to_text(judged.threshold), judged.value,
                        judged.fails ? "FAILS" : "kept");
  return text + (verdict.pass() ? "pass\n" : "FAIL\n");
}

std::string batch_text(const std::vector<PairOutcome>& outcomes) {
  std::string text = fmt::format("{:<5} {:>10} {:>10} {:>10}  pair\n", "", "flip", "ssim", "psnr");
  std::size_t failed = 0;
  for (const PairOutcome& outcome : outcomes) {
    failed += !outcome.pass();
    if (!outcome.comparison) {
      text += fmt::format("{:<5} {:>10} {:>10} {:>10}  {}: {}\n", "ERROR", "", "", "", outcome.pair.name,
                          outcome.error);
      continue;
    }
    text += fmt::format("{:<5}", outcome.pass() ? "pass" : "FAIL");
    for (const char* const name : {"flip", "ssim", "psnr"}) {
      const std::optional<double> value = find_metric(name)->value(*outcome.comparison);
      text += fmt::format(" {:>10}", value ? fmt::format("{:.5g}", *value) : "-");
    }
    text += "  " + outcome.pair.name;
    for (const std::string& failure : failures_of(outcome.verdict)) text += "; " + failure;
    text += "\n";
  }
  return text + fmt::format("{} of {} pairs {}\n", failed == 0 ? outcomes.size() : failed, outcomes.size(),
                            failed == 0 ? "pass" : "fail");
}

}  // namespace alidade
