// SPDX-License-Identifier: MIT
#include "cloud/e57/e57_columns.h"

#include <fmt/format.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "base/bytes.h"
#include "cloud/rows.h"

namespace alidade {
namespace {

using Range = std::array<double, 2>;

constexpr std::array<E57Role, 3> k_channels = {E57Role::red, E57Role::green, E57Role::blue};

bool is_usable(const E57Limits& limits) {
  return limits && std::isfinite((*limits)[1] - (*limits)[0]) && (*limits)[1] > (*limits)[0];
}

ValueScaling from_range(const Range& range) {
  return {.origin = range[0], .factor = 65535.0 / (range[1] - range[0]), .assumption = {}};
}

/// Whether values exceed a range by more than the rounding of limits that are written as text.
bool goes_beyond(const ColumnRange& values, const Range& range) {
  const double slack = 1e-5 * (range[1] - range[0]);
  return values.min <= values.max && (values.max > range[1] + slack || values.min < range[0] - slack);
}

/// The maximum of the scale of integers up to `largest`.
double full_scale(double largest) {
  if (largest <= 255.0) return 255.0;
  if (largest < 65536.0 && std::has_single_bit(static_cast<std::uint32_t>(largest) + 1)) return largest;
  return std::max(largest, 65535.0);
}

std::string widened_to(const Range& range) {
  return fmt::format("using {} to {}", range[0], range[1]);
}

std::optional<Range> color_range(const E57Limits& limits, const E57Field& field) {
  if (is_usable(limits)) return limits;
  if (!field.range) return std::nullopt;
  const double top = (*field.range)[1];
  if (field.is_integer() && field.scale == 1.0 && (*field.range)[0] >= 0.0)
    return Range{0.0, full_scale(top)};
  const bool is_whole = (*field.range)[0] == 0.0 && (top == 1.0 || top == 255.0 || top == 65535.0);
  return is_whole ? field.range : std::nullopt;
}

class Scalings {
 public:
  Scalings(const std::vector<E57Scan>& scans, const std::vector<E57Roles>& roles,
           const std::vector<E57Values>& values, AttributeSet wanted, E57Oddities& oddities)
      : scans_(scans),
        roles_(roles),
        values_(values),
        wanted_(wanted),
        oddities_(oddities),
        scalings_(scans.size()) {}

  std::vector<E57Scaling> take() {
    for (std::size_t scan = 0; scan < scans_.size(); ++scan) {
      if (wanted_.contains(Attribute::color) && roles_[scan].has(E57Role::red)) scale_colors(scan);
      if (wanted_.contains(Attribute::intensity) && roles_[scan].has(E57Role::intensity))
        scale_intensities(scan);
    }
    scale_free_ones();
    return std::move(scalings_);
  }

 private:
  const E57Field& field(std::size_t scan, E57Role role) const {
    return scans_[scan].fields[*roles_[scan].field(role)];
  }

  void warn_of_values_beyond(const char* kind, std::size_t scan, const char* what, const Range& range,
                             const ColumnRange& values, const std::string& consequence) {
    oddities_.add(kind, fmt::format("scan {}: {} from {} to {} exceed the stated range of {} to {}: {}",
                                    scan + 1, what, values.min, values.max, range[0], range[1], consequence));
  }

  void scale_colors(std::size_t scan) {
    std::array<std::optional<Range>, 3> ranges;
    for (std::size_t channel = 0; channel < 3; ++channel)
      ranges[channel] = color_range(scans_[scan].color_limits[channel], field(scan, k_channels[channel]));
    const ColumnRange& values = values_[scan].colors;
    if (!ranges[0] || !ranges[1] || !ranges[2]) {
      free_colors_.push_back(scan);
      colors_.grow(values);
      return;
    }
    // Different scales of the channels would change the hue, so all are widened.
    const auto beyond = std::ranges::find_if(
        ranges, [&](const std::optional<Range>& range) { return goes_beyond(values, *range); });
    if (beyond != ranges.end()) {
      const Range stated = **beyond;
      const bool is_little = stated == Range{0.0, 1.0} && values.min > -1.0 && values.max < 2.0;
      const Range wider = {std::min(values.min, 0.0), full_scale(values.max)};
      if (!is_little) ranges.fill(wider);
      warn_of_values_beyond(is_little ? "colours held" : "colours widened", scan, "colours", stated, values,
                            is_little ? "clamped" : widened_to(wider));
    } else if ((*ranges[0])[1] > 255.0 && values.max <= 255.0 && values.max > 0.0) {
      oddities_.add(
          "colours of 8 bits",
          fmt::format(
              "scan {}: the stated maximum of colours is {}, but none exceeds 255: they may be 8-bit values",
              scan + 1, (*ranges[0])[1]));
    }
    for (std::size_t channel = 0; channel < 3; ++channel)
      scalings_[scan].colors[channel] = from_range(*ranges[channel]);
  }

  void scale_intensities(std::size_t scan) {
    const ColumnRange& values = values_[scan].intensities;
    const E57Limits& own = scans_[scan].intensity_limits;
    const E57Limits& limits = is_usable(own) ? own : field(scan, E57Role::intensity).range;
    if (!is_usable(limits)) {
      free_intensities_.push_back(scan);
      intensities_.grow(values);
      return;
    }
    Range range = *limits;
    if (goes_beyond(values, range)) {
      range = {std::min(values.min, range[0]), std::max(values.max, range[1])};
      warn_of_values_beyond("intensities widened", scan, "intensities", *limits, values, widened_to(range));
    }
    scalings_[scan].intensities = from_range(range);
  }

  /// Scales all scans without limits by the joint ranges of their values.
  void scale_free_ones() {
    const ValueScaling colors = color_scaling(ScalarType::float64, colors_);
    const ValueScaling intensities =
        intensity_scaling(ScalarType::float64, intensities_, IntensityScale::free);
    for (const std::size_t scan : free_colors_) scalings_[scan].colors.fill(colors);
    for (const std::size_t scan : free_intensities_) scalings_[scan].intensities = intensities;
    if (!free_colors_.empty() && !colors.assumption.empty())
      oddities_.add("colours assumed", "assuming that " + colors.assumption);
    if (!free_intensities_.empty() && !intensities.assumption.empty())
      oddities_.add("intensities assumed", "assuming that " + intensities.assumption);
  }

  const std::vector<E57Scan>& scans_;
  const std::vector<E57Roles>& roles_;
  const std::vector<E57Values>& values_;
  AttributeSet wanted_;
  E57Oddities& oddities_;
  std::vector<E57Scaling> scalings_;
  std::vector<std::size_t> free_colors_, free_intensities_;
  ColumnRange colors_, intensities_;  ///< of the scans in free_colors_, free_intensities_
};

/// Nearest integer, clamped to the range of the type; NaN becomes 0.
template <class Integer>
Integer rounded(double value) {
  constexpr double k_largest = static_cast<double>(std::numeric_limits<Integer>::max());
  if (!(value > 0.0)) return 0;
  return value >= k_largest ? std::numeric_limits<Integer>::max() : static_cast<Integer>(value + 0.5);
}

/// Nearest float; 0 if the value is too large for a float, as no component of a normal is.
float normal_part(double value) {
  return std::abs(value) <= std::numeric_limits<float>::max() ? static_cast<float>(value) : 0.0f;
}

}  // namespace

std::vector<E57Scaling> e57_scalings(const std::vector<E57Scan>& scans, const std::vector<E57Roles>& roles,
                                     const std::vector<E57Values>& values, AttributeSet wanted,
                                     E57Oddities& oddities) {
  return Scalings(scans, roles, values, wanted, oddities).take();
}

void E57Appender::begin_scan(const E57Scan& scan, const E57Scaling& scaling, double time_origin) {
  scan_ = &scan;
  scaling_ = &scaling;
  time_origin_ = time_origin;
}

bool E57Appender::add(const E57Points& points) {
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    if (points.is_left_out(i)) continue;
    if (!begin_row(points.positions[i])) return false;
    put(points, i);
  }
  return true;
}

bool E57Appender::is_invalid(const E57Points& points, E57Role flag, std::size_t i, std::size_t kind) {
  if (!points.is_flagged(flag, i)) return false;
  ++invalid_[kind];
  return true;
}

void E57Appender::put_index(std::optional<std::size_t>& dimension, const char* name, const char* description,
                            double value) {
  if (!dimension)
    dimension = find_extra_dimension(cloud_, plain_dimension(name, ScalarType::uint32, description));
  auto* const bytes = reinterpret_cast<std::byte*>(cloud_.extra_dimensions[*dimension].values.data());
  store(bytes + row_ * sizeof(std::uint32_t), rounded<std::uint32_t>(value));
}

void E57Appender::put(const E57Points& points, std::size_t i) {
  const auto value = [&](E57Role role) { return points.value(role, i); };
  if (points.has(E57Role::red) && !is_invalid(points, E57Role::color_invalid, i, 0)) {
    cloud_.colors[row_] = {scaling_->colors[0].apply(value(E57Role::red)),
                           scaling_->colors[1].apply(value(E57Role::green)),
                           scaling_->colors[2].apply(value(E57Role::blue))};
  }
  if (points.has(E57Role::intensity) && !is_invalid(points, E57Role::intensity_invalid, i, 1))
    cloud_.intensities[row_] = scaling_->intensities.apply(value(E57Role::intensity));
  if (points.has(E57Role::time) && !is_invalid(points, E57Role::time_invalid, i, 2))
    cloud_.gps_times[row_] = time_origin_ + value(E57Role::time);
  if (points.has(E57Role::row))
    put_index(row_dimension_, "rowIndex", "row of the scanner's grid", value(E57Role::row));
  if (points.has(E57Role::column))
    put_index(column_dimension_, "columnIndex", "column of the scanner's grid", value(E57Role::column));
  // Counted from 0 in the file.
  if (points.has(E57Role::return_index))
    cloud_.returns[row_].number = rounded<std::uint8_t>(value(E57Role::return_index) + 1.0);
  if (points.has(E57Role::return_count))
    cloud_.returns[row_].count = rounded<std::uint8_t>(value(E57Role::return_count));
  if (points.has(E57Role::normal_x)) {
    glm::dvec3 normal(value(E57Role::normal_x), value(E57Role::normal_y), value(E57Role::normal_z));
    if (scan_->pose && scan_->pose->is_rotated) normal = scan_->pose->rotation * normal;
    cloud_.normals[row_] = {normal_part(normal.x), normal_part(normal.y), normal_part(normal.z)};
  }
}

}  // namespace alidade
