// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compare/comparison.h"

namespace alidade {

/// Which values of a figure are the good ones.
enum class Better { lower, higher };

// Groups of figures of layers, as tables head them.
constexpr std::string_view k_depth_group = "Depth", k_normal_group = "Normals", k_id_group = "Ids",
                           k_alpha_group = "Alpha";

/// A pixel, from the top left of the compared part.
struct MetricPlace {
  int x = 0, y = 0;
};

/// A figure of a comparison under the name that thresholds, JSON and tables call it by.
struct MetricKind {
  std::string_view name;   ///< "flip", "depth_rmse"
  std::string_view group;  ///< heading in tables
  std::string_view label;  ///< "FLIP, mean"
  std::string_view unit;   ///< "m", "%", or empty
  Better better;
  std::string_view note;  ///< what it is, for people who do not know it
  /// Its value; empty where the pictures do not have what it is made of.
  std::optional<double> (*value)(const Comparison& comparison);
  /// Of a largest difference, where it is; null for other figures, empty where nothing differs.
  std::optional<MetricPlace> (*place)(const Comparison& comparison) = nullptr;
};

/// All figures, in the order of tables.
std::span<const MetricKind> metric_kinds();

/// The figure of that name; null if there is none.
const MetricKind* find_metric(std::string_view name);

/// A figure with its value, which may be infinite (PSNR of equal pictures) or NaN (nothing counted).
struct Metric {
  const MetricKind* kind;
  double value;
  std::optional<MetricPlace> place{};
};

/// "FLIP, mean" of colours, "Depth: RMSE" of others: what it is called outside of tables.
std::string full_label(const MetricKind& kind);

/// What is known of these two pictures, in the order of metric_kinds().
std::vector<Metric> metrics_of(const Comparison& comparison);

}  // namespace alidade
