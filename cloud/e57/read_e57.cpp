// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <map>
#include <set>

#include "base/words.h"
#include "cloud/cloud_reader.h"
#include "cloud/e57/e57_columns.h"
#include "cloud/e57/e57_file.h"
#include "cloud/e57/e57_points.h"

namespace alidade {
namespace {

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
    about_.path = file_.pages().name();
    about_.format = "E57";
    about_.version =
        fmt::format("{}.{}", file_.pages().header().version_major, file_.pages().header().version_minor);
    std::set<std::string> unread;
    for (std::size_t i = 0; i < scans().size(); ++i) {
      const E57Roles& roles = roles_.emplace_back(scans()[i]);
      if (scans()[i].record_count == 0) continue;
      filled_scans_.push_back(i);
      if (!roles.has_cartesian() && !roles.has_spherical()) {
        file_.pages().fail(where(i), "missing coordinates",
                           "cartesianX, Y and Z or sphericalRange, Azimuth and Elevation");
      }
      attributes_ = attributes_ | roles.attributes();
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

  const CloudFile& file() const override { return about_; }
  AttributeSet attributes() const override { return attributes_; }
  FileFacts facts() const override { return facts_; }

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

  void read_in_pieces(PointCloud& cloud, AttributeSet wanted, const CloudPieces& pieces,
                      const Progress& progress) override {
    if (!survey_) survey({});
    E57Oddities assumptions;
    const AttributeSet kept = attributes_ & wanted;
    const std::vector<E57Scaling> scalings = e57_scalings(scans(), roles_, values_, kept, assumptions);
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
    about_.point_count = survey_->finite_count;
    about_.dropped_count = survey_->dropped_count;
    warn_of_invalid(appender.invalid());
    cloud.warnings.insert(cloud.warnings.end(), warnings_.begin(), warnings_.end());
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
  CloudFile about_;
  AttributeSet attributes_;
  std::vector<E57Roles> roles_;
  std::vector<std::size_t> filled_scans_;  ///< those with records
  std::vector<std::string> warnings_;
  FileFacts facts_;
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
