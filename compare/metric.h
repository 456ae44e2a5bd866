// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "compare/comparison.h"

namespace alidade {

/// Which values of a figure are the good ones.
enum class Better { lower, higher };

// Groups of figures of layers, as tables head them.
constexpr std::string_view k_depth_group = "Depth", k_normal_group = "Normals", k_id_group = "Ids";

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
};

/// All figures, in the order of tables.
std::span<const MetricKind> metric_kinds();

/// The figure of that name; null if there is none.
const MetricKind* find_metric(std::string_view name);

/// A figure with its value, which may be infinite (PSNR of equal pictures) or NaN (nothing counted).
struct Metric {
  const MetricKind* kind;
  double value;
};

/// What is known of these two pictures, in the order of metric_kinds().
std::vector<Metric> metrics_of(const Comparison& comparison);

}  // namespace alidade
