// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compare/comparison.h"

namespace alidade::compare {

/// Which values of a figure are better.
enum class Better { lower, higher };

// Groups of figures of layers, as tables head them.
constexpr std::string_view k_depth_group = "Depth", k_normal_group = "Normals", k_id_group = "Ids",
                           k_alpha_group = "Alpha";

/// A pixel, from the top left of the compared part.
struct MetricPosition {
  int x = 0, y = 0;
};

/// A figure of a comparison, under its name in thresholds, JSON and tables.
struct MetricKind {
  std::string_view name;   ///< "flip", "depth_rmse"
  std::string_view group;  ///< heading in tables
  std::string_view label;  ///< "FLIP, mean"
  std::string_view unit;   ///< "m", "%", or empty
  Better better;
  std::string_view note;  ///< explains it in tables
  /// Its value; empty where the images lack the layers it requires.
  std::optional<double> (*value)(const Comparison& comparison);
  /// Of a largest difference, where it is; null for other figures, empty where nothing differs.
  std::optional<MetricPosition> (*position)(const Comparison& comparison) = nullptr;
};

/// All figures, in the order of tables.
std::span<const MetricKind> metric_kinds();

/// The figure of that name; null if no figure has it.
const MetricKind* find_metric(std::string_view name);

/// A figure with its value, which may be infinite (PSNR of equal images) or NaN (nothing counted).
struct Metric {
  const MetricKind* kind;
  double value;
  std::optional<MetricPosition> position{};
};

/// The label outside of tables: "FLIP, mean" of colours, "Depth: RMSE" of others.
std::string full_label(const MetricKind& kind);

/// The figures that these two images have, in the order of metric_kinds().
std::vector<Metric> metrics_of(const Comparison& comparison);

/// Which values go beyond a limit. The limit itself never does.
enum class LimitKind {
  worse,  ///< '=': above it where lower is better (errors), below it where higher is better (PSNR, SSIM)
  below,  ///< '<'
  above   ///< '>'
};

/// A limit on a figure (compare/verdict.h).
struct Threshold {
  std::string metric;
  LimitKind kind = LimitKind::worse;
  double limit = 0.0;
};

/// "flip=0.05,psnr<30": thresholds between commas, each a name, one of = < > and a number or inf. Errors: an
/// empty list, an unknown name (they suggest the nearest known one), anything else behind the name, NaN.
std::vector<Threshold> parse_thresholds(const std::string& text);

/// "flip=0.05", as it is read.
std::string to_text(const Threshold& threshold);

/// A threshold and the measured value.
struct JudgedThreshold {
  Threshold threshold;
  double value = 0.0;
  bool fails_below = false;  ///< which side of the limit fails
  bool fails = false;
};

struct Verdict {
  std::vector<JudgedThreshold> judged;  ///< in the order of the thresholds

  bool pass() const;
};

/// "flip=0.05: 0.08", for those that fail.
std::vector<std::string> failures(const Verdict& verdict);

/// Judges a comparison; without thresholds it passes. NaN fails: what cannot be measured is not good enough.
/// Errors: a threshold on a figure that these images lack (no depth layer, alignment not requested).
Verdict judge(const Comparison& comparison, const std::vector<Threshold>& thresholds);

}  // namespace alidade::compare
