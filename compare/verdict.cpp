// SPDX-License-Identifier: MIT
#include "compare/verdict.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "base/error.h"
#include "base/json.h"
#include "base/words.h"

namespace alidade::compare {
namespace {

using Value = std::optional<double>;
using enum Better;

/// A figure of the colours as they are.
template <double ColorFigures::*k_figure>
Value of_colors(const Comparison& comparison) {
  if (!comparison.color) return {};
  return (*comparison.color).*k_figure;
}

template <double FlipResult::*k_figure>
Value of_flip(const Comparison& comparison) {
  if (!comparison.color) return {};
  return comparison.color->flip.*k_figure;
}

template <ErrorMetrics ColorFigures::*k_errors, double ErrorMetrics::*k_figure>
Value of_errors(const Comparison& comparison) {
  if (!comparison.color) return {};
  return ((*comparison.color).*k_errors).*k_figure;
}

/// The same with matched colours.
template <ErrorMetrics ColorFigures::*k_errors, double ErrorMetrics::*k_figure>
Value of_matched_errors(const Comparison& comparison) {
  if (!comparison.matched) return {};
  return ((*comparison.matched).*k_errors).*k_figure;
}

/// Of a layer; NaN if no pixel has it in both pictures: nothing was measured then, which is not good.
template <typename Layer>
Value of_layer(const std::optional<Layer>& layer, double Layer::*figure) {
  if (!layer) return {};
  return layer->pixels > 0 ? (*layer).*figure : std::nan("");
}

template <double DepthMetrics::*k_figure>
Value of_depth(const Comparison& comparison) {
  return of_layer(comparison.layers.depth, k_figure);
}

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

template <double AlphaMetrics::*k_figure>
Value of_alpha(const Comparison& comparison) {
  return of_layer(comparison.layers.alpha, k_figure);
}

template <double NormalMetrics::*k_figure>
Value of_normals(const Comparison& comparison) {
  return of_layer(comparison.layers.normals, k_figure);
}

Value one_sided_depth(const Comparison& comparison) {
  if (!comparison.layers.depth) return {};
  const DepthMetrics& depth = *comparison.layers.depth;
  return 100.0 * static_cast<double>(depth.only_reference + depth.only_test) /
         static_cast<double>(comparison.counted);
}

Value flip_of_matched(const Comparison& comparison) {
  if (!comparison.matched) return {};
  return comparison.matched->flip.mean;
}

Value ssim_of_matched(const Comparison& comparison) {
  if (!comparison.matched) return {};
  return comparison.matched->ssim;
}

Value equal_ids(const Comparison& comparison) {
  return of_layer(comparison.layers.ids, &IdMetrics::percent_equal);
}

Value shift(const Comparison& comparison) {
  if (!comparison.alignment) return {};
  // An unreliable shift does not count as measured.
  if (!comparison.alignment->is_certain) return std::nan("");
  return std::hypot(comparison.alignment->shift_x, comparison.alignment->shift_y);
}

Value edges(const Comparison& comparison) {
  if (!comparison.alignment) return {};
  return comparison.alignment->score_unshifted;
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
constexpr std::string_view k_colors = "Colours", k_linear = "Colours in linear light",
                           k_display = "Display colours", k_matched = "Matched colours", k_pose = "Alignment",
                           k_changes = "Change";
constexpr auto k_kinds = std::to_array<MetricKind>({
    {"flip", k_colors, "FLIP, mean", "", lower,
     "perceived difference when flipping between both: 0 none, 1 maximum", of_flip<&FlipResult::mean>},
    {"flip_median", k_colors, "FLIP, weighted median", "", lower,
     "half of the perceived difference is in pixels up to this value", of_flip<&FlipResult::weighted_median>},
    {"flip_q1", k_colors, "FLIP, weighted first quartile", "", lower, "the same for a quarter",
     of_flip<&FlipResult::weighted_first_quartile>},
    {"flip_q3", k_colors, "FLIP, weighted third quartile", "", lower, "the same for three quarters",
     of_flip<&FlipResult::weighted_third_quartile>},
    {"flip_max", k_colors, "FLIP, maximum", "", lower, "of any pixel", of_flip<&FlipResult::max>},
    {"ssim", k_colors, "SSIM", "", higher, "structural similarity: 1 equal, 0 unrelated",
     of_colors<&Colors::ssim>},
    {"ms_ssim", k_colors, "MS-SSIM", "", higher, "the same over five scales; NaN below 161 pixels",
     of_colors<&Colors::ms_ssim>},
    {"psnr", k_colors, "PSNR", "dB", higher, "peak signal to noise ratio; infinite for equal images",
     of_errors<&Colors::stored, &ErrorMetrics::psnr>},
    {"rmse", k_colors, "RMSE", "", lower, "root of the mean squared difference; the peak is 1",
     of_errors<&Colors::stored, &ErrorMetrics::rmse>},
    {"mean_abs", k_colors, "Mean absolute difference", "", lower, "over all channels; the peak is 1",
     of_errors<&Colors::stored, &ErrorMetrics::mean_abs>},
    {"mean", k_colors, "Mean signed difference", "", lower, "positive if the test is lighter",
     of_errors<&Colors::stored, &ErrorMetrics::mean>},
    {"p95", k_colors, "95th percentile", "", lower, "95 % of all absolute differences are at most this value",
     of_errors<&Colors::stored, &ErrorMetrics::percentile_95>},
    {"max", k_colors, "Maximum difference", "", lower, "of any channel of any pixel",
     of_errors<&Colors::stored, &ErrorMetrics::max_abs>, position_of_colors},
    {"psnr_linear", k_linear, "PSNR", "dB", higher, "with the sRGB curve undone",
     of_errors<&Colors::linear, &ErrorMetrics::psnr>},
    {"rmse_linear", k_linear, "RMSE", "", lower, "with the sRGB curve undone",
     of_errors<&Colors::linear, &ErrorMetrics::rmse>},
    {"psnr_display", k_display, "PSNR", "dB", higher, "of sRGB values; linear light is clamped to 0 and 1",
     of_errors<&Colors::display, &ErrorMetrics::psnr>},
    {"rmse_display", k_display, "RMSE", "", lower, "of sRGB values",
     of_errors<&Colors::display, &ErrorMetrics::rmse>},
    {"flip_matched", k_matched, "FLIP, mean", "", lower, "after --match", flip_of_matched},
    {"ssim_matched", k_matched, "SSIM", "", higher, "after --match", ssim_of_matched},
    {"psnr_matched", k_matched, "PSNR", "dB", higher, "after --match",
     of_matched_errors<&Colors::stored, &ErrorMetrics::psnr>},
    {"rmse_matched", k_matched, "RMSE", "", lower, "after --match",
     of_matched_errors<&Colors::stored, &ErrorMetrics::rmse>},
    {"shift", k_pose, "Shift", "px", lower, "of the test, where the edges fit best; requires --align", shift},
    {"edges", k_pose, "Common edges", "", higher,
     "correlation of gradients without a shift: 1 for equal edges; requires --align", edges},
    {"depth_mean", k_depth_group, "Mean absolute difference", "m", lower,
     "of the layers Z, where both have depth", of_depth<&DepthMetrics::mean_abs>},
    {"depth_offset", k_depth_group, "Mean signed difference", "m", lower,
     "positive if the test is farther away", of_depth<&DepthMetrics::mean>},
    {"depth_rmse", k_depth_group, "RMSE", "m", lower, "of the layers Z", of_depth<&DepthMetrics::rmse>},
    {"depth_p95", k_depth_group, "95th percentile", "m", lower,
     "95 % of the absolute differences are at most this value", of_depth<&DepthMetrics::percentile_95>},
    {"depth_max", k_depth_group, "Maximum difference", "m", lower, "of the layers Z",
     of_depth<&DepthMetrics::max_abs>, position_of_layer<&LayerMetrics::depth>},
    {"depth_relative", k_depth_group, "Mean relative difference", "", lower,
     "absolute difference divided by the depth of the reference", of_depth<&DepthMetrics::mean_relative>},
    {"depth_1cm", k_depth_group, "Within 1 cm", "%", higher, "pixels whose depths differ by at most 0.01 m",
     of_depth<&DepthMetrics::percent_within_1_cm>},
    {"depth_5cm", k_depth_group, "Within 5 cm", "%", higher, "by at most 0.05 m",
     of_depth<&DepthMetrics::percent_within_5_cm>},
    {"depth_1percent", k_depth_group, "Within 1 %", "%", higher, "by at most 1 % of the depth",
     of_depth<&DepthMetrics::percent_within_1_percent>},
    {"depth_one_sided", k_depth_group, "In one image only", "%", lower,
     "pixels where only one image has depth", one_sided_depth},
    {"normal_mean", k_normal_group, "Mean angle", "deg", lower, "between the normals, in degrees",
     of_normals<&NormalMetrics::mean>},
    {"normal_p95", k_normal_group, "95th percentile", "deg", lower,
     "95 % of the angles are at most this value", of_normals<&NormalMetrics::percentile_95>},
    {"normal_max", k_normal_group, "Maximum angle", "deg", lower, "between the normals",
     of_normals<&NormalMetrics::max>, position_of_layer<&LayerMetrics::normals>},
    {"ids", k_id_group, "Equal ids", "%", higher, "pixels that show the same point in both", equal_ids},
    {"alpha_mean", k_alpha_group, "Mean absolute difference", "", lower, "of the channels A; the peak is 1",
     of_alpha<&AlphaMetrics::mean_abs>},
    {"alpha_max", k_alpha_group, "Maximum difference", "", lower, "the peak is 1",
     of_alpha<&AlphaMetrics::max_abs>, position_of_layer<&LayerMetrics::alpha>},
    {"changed", k_changes, "Changed pixels", "%", lower, "of the compared pixels; requires --changes",
     changed},
    {"regions", k_changes, "Regions", "", lower, "of changed pixels; requires --changes", regions},
});

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

namespace {

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
                   .problem = fmt::format("the images have no '{}' for a threshold", kind.name),
                   .expected = std::string(kind.note)});
    }
    verdict.judged.push_back(judged(threshold, *value, kind.better));
  }
  return verdict;
}

}  // namespace alidade::compare
