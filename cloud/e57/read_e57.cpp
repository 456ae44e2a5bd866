// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/words.h"
#include "cloud/cloud_reader.h"
#include "cloud/e57/e57_file.h"
#include "cloud/e57/e57_points.h"
#include "cloud/point_cloud.h"
#include "cloud/point_table.h"
#include "cloud/rows.h"

namespace alidade {
namespace {

/// How the values of one scan become 0 .. 65535.
struct E57Scaling {
  std::array<ValueScaling, 3> colors;  ///< red, green, blue
  ValueScaling intensities;
};

/// Ranges of the values of one scan in the first pass, without those flagged as invalid.
struct E57Values {
  ColumnRange colors, intensities;
};

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

/// Determines how the values of every scan become 0 .. 65535. The range of a scan is the first of these:
/// - its limits (colorLimits, intensityLimits), if the largest is above the smallest;
/// - of intensities, the range that the field states; of integer colours, 0 to 255 or 65535, whichever holds
///   the field's maximum, or to that maximum itself if it is one less than a power of two above 255, because
///   many fields state the values that occur instead of those that can occur; of colours as floats, the
///   field's range if it is 0 to 1, 255 or 65535;
/// - color_scaling() or intensity_scaling() of the values of all remaining scans together.
/// Values outside of a stated range widen it: colours to 255 or 65535, intensities to the values. Colours
/// between -1 and 2 are clamped to a range of 0 to 1 instead, because filters overshoot by that much. Every
/// assumption, widening and clamping is added to `oddities`.
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

/// Appends the points of scans to a cloud. Attributes that a scan lacks are 0.
class E57Appender : public RowsToFill {
 public:
  /// Appends rows of zeros for the next `count` points, as far as a piece has room, and the columns of
  /// `filled`. `pieces` must outlive the object.
  E57Appender(PointCloud& cloud, AttributeSet filled, std::uint64_t count, const CloudPieces& pieces)
      : RowsToFill(cloud, filled, count, pieces) {
    make_rows();
  }

  /// Sets how values of the next scan are read: its scaling, its pose (for normals), and the origin of its
  /// time stamps.
  void begin_scan(const E57Scan& scan, const E57Scaling& scaling, double time_origin) {
    scan_ = &scan;
    scaling_ = &scaling;
    time_origin_ = time_origin;
  }

  /// Takes the next points, without those that are left out. Returns false as begin_row() does.
  bool add(const E57Points& points) {
    for (std::size_t i = 0; i < points.positions.size(); ++i) {
      if (points.is_left_out(i)) continue;
      if (!begin_row(points.positions[i])) return false;
      put(points, i);
    }
    return true;
  }

  /// Numbers of values that are flagged as invalid and became 0: colours, intensities, time stamps.
  const std::array<std::uint64_t, 3>& invalid() const { return invalid_; }

 private:
  void put(const E57Points& points, std::size_t i) {
    const auto value = [&](E57Role role) { return points.value(role, i); };
    const auto is_invalid = [&](E57Role flag, std::size_t kind) {
      const bool is_flagged = points.is_flagged(flag, i);
      invalid_[kind] += is_flagged ? 1 : 0;
      return is_flagged;
    };
    if (points.has(E57Role::red) && !is_invalid(E57Role::color_invalid, 0)) {
      cloud_.colors[row_] = {scaling_->colors[0].apply(value(E57Role::red)),
                             scaling_->colors[1].apply(value(E57Role::green)),
                             scaling_->colors[2].apply(value(E57Role::blue))};
    }
    if (points.has(E57Role::intensity) && !is_invalid(E57Role::intensity_invalid, 1))
      cloud_.intensities[row_] = scaling_->intensities.apply(value(E57Role::intensity));
    if (points.has(E57Role::time) && !is_invalid(E57Role::time_invalid, 2))
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

  void put_index(std::optional<std::size_t>& dimension, const char* name, const char* description,
                 double value) {
    if (!dimension)
      dimension = find_extra_dimension(cloud_, plain_dimension(name, ScalarType::uint32, description));
    auto* const bytes = reinterpret_cast<std::byte*>(cloud_.extra_dimensions[*dimension].values.data());
    store(bytes + row_ * sizeof(std::uint32_t), rounded<std::uint32_t>(value));
  }

  std::optional<std::size_t> row_dimension_{}, column_dimension_{};  ///< once a scan has one
  const E57Scan* scan_ = nullptr;
  const E57Scaling* scaling_ = nullptr;
  double time_origin_ = 0.0;
  std::array<std::uint64_t, 3> invalid_{};
};

/// From seconds since the GPS epoch, as in E57, to adjusted standard GPS time.
constexpr double k_adjusted_gps_time = -1e9;

/// OGC WKT: a keyword in capitals, then an opening bracket.
bool is_wkt(const std::string& text) {
  const std::size_t word = text.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789");
  if (word == 0 || word == std::string::npos) return false;
  const std::size_t bracket = text.find_first_not_of(" \t\r\n", word);
  return bracket != std::string::npos && (text[bracket] == '[' || text[bracket] == '(');
}

/// The first twenty names in quotes, and how many more there are.
std::string listed(const std::set<std::string>& names) {
  constexpr std::size_t k_first = 20;
  std::vector<std::string> words;
  for (const std::string& name : names) {
    if (words.size() == k_first) break;
    words.push_back(quote(name));
  }
  const std::size_t more = names.size() - words.size();
  return fmt::format("{}{}", fmt::join(words, ", "), more > 0 ? fmt::format(" and {} more", more) : "");
}

class E57Reader final : public CloudReader {
 public:
  explicit E57Reader(InputFile input) : file_(std::move(input)) {
    facts_.file.path = file_.pages().name();
    facts_.file.format = "E57";
    facts_.file.version =
        fmt::format("{}.{}", file_.pages().header().version_major, file_.pages().header().version_minor);
    facts_.bytes = file_.pages().file_size();
    std::set<std::string> unread;
    for (std::size_t i = 0; i < scans().size(); ++i) {
      const E57Roles& roles = roles_.emplace_back(scans()[i]);
      if (scans()[i].record_count == 0) continue;
      filled_scans_.push_back(i);
      if (!roles.has_cartesian() && !roles.has_spherical()) {
        file_.pages().fail(where(i), "missing coordinates",
                           "cartesianX, Y and Z or sphericalRange, Azimuth and Elevation");
      }
      facts_.attributes = facts_.attributes | roles.attributes();
      unread.insert(roles.unread().begin(), roles.unread().end());
    }
    find_time_origins();
    for (const std::string& oddity : file_.document().oddities.clauses()) warn(oddity);
    if (const std::string& text = file_.document().coordinate_metadata; is_wkt(text)) {
      facts_.crs.wkt = text;
    } else if (!text.empty()) {
      warn("the coordinate metadata is not WKT and was ignored: " + quote(text));
    }
    if (!unread.empty()) warn("skipped the fields " + listed(unread));
  }

  CoordinateSurvey survey(const Progress& progress) override {
    CoordinateSurvey survey;
    survey.resolution = glm::dvec3(std::numeric_limits<double>::infinity());
    values_.assign(scans().size(), {});
    left_out_ = {};
    const auto grow = [](ColumnRange& range, const E57Points& points, E57Role role, std::size_t i) {
      if (points.has(role) && std::isfinite(points.value(role, i))) range.grow(points.value(role, i));
    };
    for (const std::size_t scan : filled_scans_) {
      E57Values& values = values_[scan];
      const E57PointReader reader =
          visit_scan(scan, Attribute::color | Attribute::intensity, progress, [&](const E57Points& points) {
            for (std::size_t i = 0; i < points.positions.size(); ++i) {
              if (points.is_left_out(i)) continue;
              ++survey.finite_count;
              survey.bounds.grow(points.positions[i]);
              if (!points.is_flagged(E57Role::color_invalid, i)) {
                for (const E57Role role : {E57Role::red, E57Role::green, E57Role::blue})
                  grow(values.colors, points, role, i);
              }
              if (!points.is_flagged(E57Role::intensity_invalid, i))
                grow(values.intensities, points, E57Role::intensity, i);
            }
          });
      survey.resolution = glm::min(survey.resolution, reader.resolution());
      left_out_.directions += reader.left_out().directions;
      left_out_.unknown += reader.left_out().unknown;
      left_out_.not_finite += reader.left_out().not_finite;
    }
    if (survey.finite_count == 0) survey.resolution = glm::dvec3(0.0);
    survey.dropped_count = left_out_.total();
    survey_ = survey;
    return survey;
  }

  FileRead read(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                const Progress& progress) override {
    if (!survey_) survey({});
    E57Oddities assumptions;
    const AttributeSet kept = facts_.attributes & wanted;
    const std::vector<E57Scaling> scalings = Scalings(scans(), roles_, values_, kept, assumptions).take();
    for (const std::string& assumption : assumptions.clauses()) warn(assumption);
    for (const E57Scan& scan : scans()) {
      if (scan.pose) cloud.scanner_positions.push_back({scan.name, scan.pose->translation});
    }
    E57Appender appender(cloud, kept, survey_->finite_count, pieces);
    for (const std::size_t scan : filled_scans_) {
      appender.begin_scan(scans()[scan], scalings[scan], time_origins_[scan]);
      visit_scan(scan, kept, progress, [&](const E57Points& points) {
        if (appender.add(points)) return;
        file_.pages().fail(where(scan),
                           "a point lies outside the lattice, or the file changed while it was read");
      });
    }
    if (!appender.complete()) file_.pages().fail({}, "the file changed while it was read");
    warn_of_gaps(kept);
    if (const auto steps = coarse_floats(*survey_)) warn(*steps);
    warn_of_invalid(appender.invalid());
    cloud.warnings.insert(cloud.warnings.end(), warnings_.begin(), warnings_.end());
    return read_rows(survey_->finite_count, survey_->dropped_count);
  }

  void rest() override { file_.pages().rest(); }

 private:
  const std::vector<E57Scan>& scans() const { return file_.document().scans; }
  static std::string where(std::size_t scan) { return fmt::format("scan {}", scan + 1); }
  void warn(const std::string& clause) { warnings_.push_back(file_.pages().name() + ": " + clause); }

  /// Passes the points of one scan to `visitor`. Returns the reader of the scan.
  E57PointReader visit_scan(std::size_t scan, AttributeSet attributes, const Progress& progress,
                            const std::function<void(const E57Points&)>& visitor) {
    const E57Scan& about = scans()[scan];
    E57PointReader reader(about, roles_[scan]);
    std::uint64_t done = 0;
    reader.visit(file_.pages(), where(scan), attributes, [&](const E57Points& points) {
      const double share = static_cast<double>(done) / static_cast<double>(about.record_count);
      const double bytes = static_cast<double>(about.end - about.begin);
      report(progress, about.begin + static_cast<std::uint64_t>(share * bytes), file_.pages().file_size());
      visitor(points);
      done += points.positions.size();
    });
    return reader;
  }

  /// The origin of the time stamps of each scan. Adjusted standard GPS time requires the start of every scan.
  void find_time_origins() {
    time_origins_.assign(scans().size(), 0.0);
    std::size_t timed = 0, dated = 0;
    for (const std::size_t scan : filled_scans_) {
      if (!roles_[scan].has(E57Role::time)) continue;
      ++timed;
      if (scans()[scan].start) ++dated;
    }
    const bool is_standard = timed > 0 && dated == timed;
    facts_.gps_time_is_standard = is_standard;
    for (std::size_t scan = 0; is_standard && scan < scans().size(); ++scan)
      time_origins_[scan] = scans()[scan].start.value_or(0.0) + k_adjusted_gps_time;
    if (dated < timed)
      warn(
          "time stamps are relative to the start of each scan, which the file does not state for every scan");
  }

  /// Warns of attributes that are zeros in some scans, because these lack them.
  void warn_of_gaps(AttributeSet kept) {
    std::map<std::string, std::size_t> lacking;
    for (const std::size_t scan : filled_scans_) {
      AttributeSet missing;
      missing.bits = kept.bits & ~roles_[scan].attributes().bits;
      for (const std::string& name : attribute_names(missing)) ++lacking[name];
    }
    for (const auto& [name, count] : lacking) {
      warn(fmt::format("{} of {} scans {} no {}; using 0", count, filled_scans_.size(),
                       count == 1 ? "has" : "have", name));
    }
  }

  /// Warns of points that were skipped, and of others whose values are flagged as invalid.
  void warn_of_invalid(const std::array<std::uint64_t, 3>& invalid) {
    const auto warn_of = [&](std::uint64_t count, const char* form) {
      if (count > 0) warn(fmt::format(fmt::runtime(form), count));
    };
    warn_of(left_out_.directions, "skipped {} points with a direction only");
    warn_of(left_out_.unknown, "skipped {} points that are flagged as invalid");
    warn_of(left_out_.not_finite, "skipped {} points without finite coordinates");
    warn_of(invalid[0], "{} points have a colour flagged as invalid; using 0");
    warn_of(invalid[1], "{} points have an intensity flagged as invalid; using 0");
    warn_of(invalid[2], "{} points have a time flagged as invalid; using 0");
  }

  E57File file_;
  std::vector<E57Roles> roles_;
  std::vector<std::size_t> filled_scans_;  ///< those with records
  std::vector<std::string> warnings_;
  std::vector<double> time_origins_;  ///< of each scan
  // Results of the first pass.
  std::vector<E57Values> values_;
  E57LeftOut left_out_;
  std::optional<CoordinateSurvey> survey_;
};

}  // namespace

std::unique_ptr<CloudReader> open_e57(InputFile file, Damage) {
  return std::make_unique<E57Reader>(std::move(file));
}

}  // namespace alidade
