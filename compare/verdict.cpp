// SPDX-License-Identifier: MIT
#include "compare/verdict.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "base/error.h"
#include "base/words.h"

namespace alidade::compare {
namespace {

using Value = std::optional<double>;
using enum Better;

/// A figure of a part of the comparison, by the members that lead to it.
template <auto k_part, auto... k_members>
Value figure_of(const Comparison& comparison) {
  const auto& part = comparison.*k_part;
  if (!part) return {};
  return (*part.*....*k_members);
}

/// Figures of the colours as they are, and of matched ones.
template <auto... k_members>
constexpr auto k_color = figure_of<&Comparison::color, k_members...>;
template <auto k_figure>
constexpr auto k_stored = k_color<&ColorFigures::stored, k_figure>;
template <auto k_figure>
constexpr auto k_flip = k_color<&ColorFigures::flip, k_figure>;
template <auto... k_members>
constexpr auto k_matched = figure_of<&Comparison::matched, k_members...>;

/// Of a layer; NaN if no pixel has it in both images: nothing was measured then, which is not good.
template <auto k_layer, auto k_figure>
Value of_layer(const Comparison& comparison) {
  const auto& layer = comparison.layers.*k_layer;
  if (!layer) return {};
  return layer->pixels > 0 ? (*layer).*k_figure : std::nan("");
}
template <double DepthMetrics::*k_figure>
constexpr auto k_depth = of_layer<&LayerMetrics::depth, k_figure>;

std::optional<MetricPosition> position(int x, int y) {
  if (x < 0) return {};
  return MetricPosition{x, y};
}

/// Where the largest difference of a layer is.
template <auto k_layer>
std::optional<MetricPosition> position_of_layer(const Comparison& comparison) {
  const auto& layer = comparison.layers.*k_layer;
  if (!layer) return {};
  return position(layer->max_x, layer->max_y);
}

std::optional<MetricPosition> position_of_colors(const Comparison& comparison) {
  if (!comparison.color) return {};
  return position(comparison.color->stored.max_x, comparison.color->stored.max_y);
}

Value one_sided_depth(const Comparison& comparison) {
  if (!comparison.layers.depth) return {};
  const DepthMetrics& depth = *comparison.layers.depth;
  return 100.0 * static_cast<double>(depth.only_reference + depth.only_test) /
         static_cast<double>(comparison.counted);
}

/// Percentage of the pixels; NaN if neither image has any depth.
template <std::uint64_t AgreementMetrics::*k_count>
Value agreement(const Comparison& comparison) {
  if (!comparison.layers.agreement) return {};
  const AgreementMetrics& found = *comparison.layers.agreement;
  if (found.agreeing + found.differing + found.not_scanned == 0) return std::nan("");
  return 100.0 * static_cast<double>(found.*k_count) / static_cast<double>(comparison.counted);
}

Value shift(const Comparison& comparison) {
  if (!comparison.alignment) return {};
  // An unreliable shift does not count as measured.
  if (!comparison.alignment->is_certain) return std::nan("");
  return std::hypot(comparison.alignment->shift_x, comparison.alignment->shift_y);
}

Value changed(const Comparison& comparison) {
  if (!comparison.changes) return {};
  return 100.0 * static_cast<double>(comparison.changes->changed_pixels) /
         static_cast<double>(comparison.counted);
}

Value regions(const Comparison& comparison) {
  if (!comparison.changes) return {};
  return static_cast<double>(comparison.changes->regions.size());
}

using Colors = ColorFigures;
using Layers = LayerMetrics;
constexpr std::string_view k_colors = "Colours", k_linear = "Colours in linear light",
                           k_display = "Display colours", k_matched_group = "Matched colours",
                           k_pose = "Alignment", k_changes = "Change";
constexpr auto k_kinds = std::to_array<MetricKind>({
    {"flip", k_colors, "FLIP, mean", "", lower,
     "perceived difference when flipping between both: 0 none, 1 maximum", k_flip<&FlipResult::mean>},
    {"flip_median", k_colors, "FLIP, weighted median", "", lower,
     "half of the perceived difference is in pixels up to this value", k_flip<&FlipResult::weighted_median>},
    {"flip_q1", k_colors, "FLIP, weighted first quartile", "", lower, "the same for a quarter",
     k_flip<&FlipResult::weighted_first_quartile>},
    {"flip_q3", k_colors, "FLIP, weighted third quartile", "", lower, "the same for three quarters",
     k_flip<&FlipResult::weighted_third_quartile>},
    {"flip_max", k_colors, "FLIP, maximum", "", lower, "of any pixel", k_flip<&FlipResult::max>},
    {"ssim", k_colors, "SSIM", "", higher, "structural similarity: 1 equal, 0 unrelated",
     k_color<&Colors::ssim>},
    {"ms_ssim", k_colors, "MS-SSIM", "", higher, "the same over five scales; NaN below 161 pixels",
     k_color<&Colors::ms_ssim>},
    {"psnr", k_colors, "PSNR", "dB", higher, "peak signal to noise ratio; infinite for equal images",
     k_stored<&ErrorMetrics::psnr>},
    {"rmse", k_colors, "RMSE", "", lower, "root of the mean squared difference; the peak is 1",
     k_stored<&ErrorMetrics::rmse>},
    {"mean_abs", k_colors, "Mean absolute difference", "", lower, "over all channels; the peak is 1",
     k_stored<&ErrorMetrics::mean_abs>},
    {"mean", k_colors, "Mean signed difference", "", lower, "positive if the test is lighter",
     k_stored<&ErrorMetrics::mean>},
    {"p95", k_colors, "95th percentile", "", lower, "95 % of all absolute differences are at most this value",
     k_stored<&ErrorMetrics::percentile_95>},
    {"max", k_colors, "Maximum difference", "", lower, "of any channel of any pixel",
     k_stored<&ErrorMetrics::max_abs>, position_of_colors},
    {"psnr_linear", k_linear, "PSNR", "dB", higher, "with the sRGB curve undone",
     k_color<&Colors::linear, &ErrorMetrics::psnr>},
    {"rmse_linear", k_linear, "RMSE", "", lower, "with the sRGB curve undone",
     k_color<&Colors::linear, &ErrorMetrics::rmse>},
    {"psnr_display", k_display, "PSNR", "dB", higher, "of sRGB values; linear light is clamped to 0 and 1",
     k_color<&Colors::display, &ErrorMetrics::psnr>},
    {"rmse_display", k_display, "RMSE", "", lower, "of sRGB values",
     k_color<&Colors::display, &ErrorMetrics::rmse>},
    {"flip_matched", k_matched_group, "FLIP, mean", "", lower, "after --match",
     k_matched<&Colors::flip, &FlipResult::mean>},
    {"ssim_matched", k_matched_group, "SSIM", "", higher, "after --match", k_matched<&Colors::ssim>},
    {"psnr_matched", k_matched_group, "PSNR", "dB", higher, "after --match",
     k_matched<&Colors::stored, &ErrorMetrics::psnr>},
    {"rmse_matched", k_matched_group, "RMSE", "", lower, "after --match",
     k_matched<&Colors::stored, &ErrorMetrics::rmse>},
    {"shift", k_pose, "Shift", "px", lower, "of the test, where the edges fit best; requires --align", shift},
    {"edges", k_pose, "Common edges", "", higher,
     "correlation of gradients without a shift: 1 for equal edges; requires --align",
     figure_of<&Comparison::alignment, &Alignment::score_unshifted>},
    {"depth_mean", k_depth_group, "Mean absolute difference", "m", lower,
     "of the layers Z, where both have depth", k_depth<&DepthMetrics::mean_abs>},
    {"depth_offset", k_depth_group, "Mean signed difference", "m", lower,
     "positive if the test is farther away", k_depth<&DepthMetrics::mean>},
    {"depth_rmse", k_depth_group, "RMSE", "m", lower, "of the layers Z", k_depth<&DepthMetrics::rmse>},
    {"depth_p95", k_depth_group, "95th percentile", "m", lower,
     "95 % of the absolute differences are at most this value", k_depth<&DepthMetrics::percentile_95>},
    {"depth_max", k_depth_group, "Maximum difference", "m", lower, "of the layers Z",
     k_depth<&DepthMetrics::max_abs>, position_of_layer<&Layers::depth>},
    {"depth_relative", k_depth_group, "Mean relative difference", "", lower,
     "absolute difference divided by the depth of the reference", k_depth<&DepthMetrics::mean_relative>},
    {"depth_1cm", k_depth_group, "Within 1 cm", "%", higher, "pixels whose depths differ by at most 0.01 m",
     k_depth<&DepthMetrics::percent_within_1_cm>},
    {"depth_5cm", k_depth_group, "Within 5 cm", "%", higher, "by at most 0.05 m",
     k_depth<&DepthMetrics::percent_within_5_cm>},
    {"depth_1percent", k_depth_group, "Within 1 %", "%", higher, "by at most 1 % of the depth",
     k_depth<&DepthMetrics::percent_within_1_percent>},
    {"depth_one_sided", k_depth_group, "In one image only", "%", lower,
     "pixels where only one image has depth", one_sided_depth},
    {"depth_agrees", k_depth_group, "Agrees", "%", higher,
     "pixels whose depths differ by at most three standard deviations; requires the layer depth.sigma",
     agreement<&AgreementMetrics::agreeing>},
    {"depth_differs", k_depth_group, "Differs", "%", lower,
     "pixels beyond that, or with depth where an image of exact surfaces has none; requires depth.sigma",
     agreement<&AgreementMetrics::differing>},
    {"depth_not_scanned", k_depth_group, "Not scanned", "%", lower,
     "pixels with depth in one image where the other, a scan, has none; requires depth.sigma",
     agreement<&AgreementMetrics::not_scanned>},
    {"normal_mean", k_normal_group, "Mean angle", "deg", lower, "between the normals, in degrees",
     of_layer<&Layers::normals, &NormalMetrics::mean>},
    {"normal_p95", k_normal_group, "95th percentile", "deg", lower,
     "95 % of the angles are at most this value", of_layer<&Layers::normals, &NormalMetrics::percentile_95>},
    {"normal_max", k_normal_group, "Maximum angle", "deg", lower, "between the normals",
     of_layer<&Layers::normals, &NormalMetrics::max>, position_of_layer<&Layers::normals>},
    {"ids", k_id_group, "Equal ids", "%", higher, "pixels that show the same point in both",
     of_layer<&Layers::ids, &IdMetrics::percent_equal>},
    {"alpha_mean", k_alpha_group, "Mean absolute difference", "", lower, "of the channels A; the peak is 1",
     of_layer<&Layers::alpha, &AlphaMetrics::mean_abs>},
    {"alpha_max", k_alpha_group, "Maximum difference", "", lower, "the peak is 1",
     of_layer<&Layers::alpha, &AlphaMetrics::max_abs>, position_of_layer<&Layers::alpha>},
    {"changed", k_changes, "Changed pixels", "%", lower, "of the compared pixels; requires --changes",
     changed},
    {"regions", k_changes, "Regions", "", lower, "of changed pixels; requires --changes", regions},
});

[[noreturn]] void reject(const std::string& problem, const std::string& found) {
  throw Error({.problem = problem,
               .expected = "NAME=LIMIT, NAME<LIMIT or NAME>LIMIT, such as psnr<30",
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
  throw Error({.problem = fmt::format("unknown metric '{}' in a threshold", name),
               .expected = nearest.empty() ? "one of " + all
                                           : fmt::format("one of {1} (did you mean '{0}'?)", nearest, all)});
}

double limit_of(std::string_view text, const std::string& whole) {
  double limit = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), limit);
  if (error != std::errc{} || end != text.data() + text.size() || std::isnan(limit))
    reject("missing limit of a threshold", whole);
  return limit;
}

Threshold parse_threshold(const std::string& text) {
  const std::size_t sign = text.find_first_of("=<>");
  if (sign == std::string::npos) reject("invalid threshold", text);
  const std::string_view view = text;
  const std::string_view name = trimmed(view.substr(0, sign));
  if (name.empty()) reject("missing threshold name", text);
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

std::span<const MetricKind> metric_kinds() {
  return k_kinds;
}

const MetricKind* find_metric(std::string_view name) {
  const auto found = std::ranges::find(k_kinds, name, &MetricKind::name);
  return found == k_kinds.end() ? nullptr : &*found;
}

std::vector<Metric> metrics_of(const Comparison& comparison) {
  std::vector<Metric> metrics;
  for (const MetricKind& kind : k_kinds)
    if (const Value value = kind.value(comparison))
      metrics.push_back({&kind, *value, kind.position != nullptr ? kind.position(comparison) : std::nullopt});
  return metrics;
}

std::string full_label(const MetricKind& kind) {
  std::string label(kind.label);
  return kind.group == k_colors ? label : std::string(kind.group) + ": " + label;
}

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

std::vector<std::string> failures(const Verdict& verdict) {
  std::vector<std::string> texts;
  for (const JudgedThreshold& judged : verdict.judged)
    if (judged.fails) texts.push_back(fmt::format("{}: {:.6g}", to_text(judged.threshold), judged.value));
  return texts;
}

Verdict judge(const Comparison& comparison, const std::vector<Threshold>& thresholds) {
  Verdict verdict;
  for (const Threshold& threshold : thresholds) {
    const MetricKind& kind = known_metric(threshold.metric);
    const std::optional<double> value = kind.value(comparison);
    if (!value) {
      throw Error(comparison.test.file.string(), {},
                  fmt::format("the images have no '{}' for a threshold", kind.name), std::string(kind.note));
    }
    verdict.judged.push_back(judged(threshold, *value, kind.better));
  }
  return verdict;
}

}  // namespace alidade::compare
