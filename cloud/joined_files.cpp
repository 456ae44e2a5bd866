// SPDX-License-Identifier: MIT
#include "cloud/joined_files.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <algorithm>
#include <array>
#include <filesystem>
#include <glm/common.hpp>
#include <map>
#include <set>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "cloud/crs.h"
#include "cloud/lattice.h"

namespace alidade {
namespace {

std::string text_of(const glm::dvec3& value) {
  return fmt::format("{}, {}, {}", value.x, value.y, value.z);
}

bool has_lattice(const CloudSource& source) {
  return source.has_lattice;
}

bool has_crs(const CloudSource& source) {
  return !source.facts.crs.empty();
}

/// The first source that has a property which all must share: one with points, if there is any.
template <class Has>
const CloudSource* first_that_binds(const std::vector<CloudSource>& sources, const Has& has) {
  const CloudSource* first = nullptr;
  for (const CloudSource& source : sources) {
    if (!has(source) || (first && (first->point_count() > 0 || source.point_count() == 0))) continue;
    first = &source;
  }
  return first;
}

/// Compares systems with one, each only once: tiles mostly share one, and a comparison takes a millisecond.
class ComparedSystems {
 public:
  explicit ComparedSystems(const Crs& crs) : crs_(crs) {}

  CrsAgreement with(const Crs& other) {
    const auto known = std::ranges::find_if(known_, [&](const auto& one) { return *one.first == other; });
    if (known != known_.end()) return known->second;
    return known_.emplace_back(&other, compare_crs(other, crs_)).second;
  }

 private:
  const Crs& crs_;
  std::vector<std::pair<const Crs*, CrsAgreement>> known_;
};

[[noreturn]] void reject_crs(const CloudSource& odd, const CloudSource& other) {
  throw file_error(odd.path(),
                   "the coordinate reference system differs from that of " + other.path().string(),
                   crs_name(other.facts.crs) + " (alidade convert --reproject SYSTEM brings files to one)",
                   crs_name(odd.facts.crs));
}

/// Errors: heights of some files are converted, and other files do not state a system.
void check_heights(const std::vector<CloudSource>& sources) {
  const auto converted = std::ranges::find_if(
      sources, [](const CloudSource& source) { return !source.facts.heights_note.empty(); });
  if (converted == sources.end()) return;
  for (const CloudSource& source : sources) {
    if (!source.is_open || has_crs(source) || source.point_count() == 0) continue;
    throw file_error(source.path(),
                     "no coordinate reference system, and the heights of " + converted->path().string() +
                         " are converted to the unit of x and y",
                     "--crs EPSG:n, which states one");
  }
}

/// Warns of copies under other names, and of tiles that are given as LAS and as LAZ.
void warn_of_copies(PointCloud& cloud) {
  // Files of few points may agree in number and bounds by chance.
  constexpr std::uint64_t k_few = 1000;
  std::map<std::array<double, 7>, std::string> known;
  SomeFiles copies;
  std::string original;
  for (const CloudFile& file : cloud.files) {
    if (!file.stated_bounds || file.point_count < k_few) continue;
    const auto& [low, high] = *file.stated_bounds;
    if (low == high) continue;  // the writer left them empty
    const auto [same, is_new] = known.try_emplace(
        {low.x, low.y, low.z, high.x, high.y, high.z, static_cast<double>(file.point_count)},
        file.path.string());
    std::error_code error;
    if (is_new || same->second == file.path.string() ||
        std::filesystem::equivalent(same->second, file.path, error))
      continue;  // one file under two names: see warn_of_twins()
    if (copies.count() == 0) original = same->second;
    copies.add(file.path.string());
  }
  if (copies.count() == 0) return;
  cloud.warnings.push_back(
      fmt::format("{}: as many points within the same bounds as {}; the points may be repeated",
                  copies.text(), copies.count() == 1 ? original : "other files"));
}

}  // namespace

void SomeFiles::add(const std::string& file) {
  if (count_++ == 0) first_ = file;
}

std::string SomeFiles::text() const {
  if (count_ < 2) return first_;
  return fmt::format("{} and {} more file{}", first_, count_ - 1, count_ == 2 ? "" : "s");
}

Lattice common_lattice(const std::vector<CloudSource>& sources) {
  const CloudSource* const first = first_that_binds(sources, has_lattice);
  if (!first) {
    std::vector<CoordinateSurvey> surveys;
    for (const CloudSource& source : sources) surveys.push_back(source.survey);
    const auto reach = [](const CloudSource& source) {
      const Bounds& bounds = source.survey.bounds;
      const glm::dvec3 most = glm::max(glm::abs(bounds.min), glm::abs(bounds.max));
      return bounds.empty() ? 0.0 : std::max({most.x, most.y, most.z});
    };
    const auto farthest = std::ranges::max_element(sources, {}, reach);
    return with_file(farthest == sources.end() ? "" : farthest->path().string(),
                     [&] { return fit_lattice(surveys); });
  }
  std::vector<Lattice> lattices = {*first->reader->lattice()};
  Bounds bounds;
  for (const CloudSource& source : sources) {
    if (source.point_count() == 0) continue;
    bounds.grow(source.has_lattice ? source.facts.box.value_or(Bounds()) : source.survey.bounds);
    if (source.has_lattice) lattices.push_back(*source.reader->lattice());
  }
  const Lattice lattice = joined_lattice(lattices, bounds);
  for (const CloudSource& source : sources) {
    if (source.has_lattice || source.point_count() == 0) continue;
    const Bounds& own = source.survey.bounds;
    if (to_lattice(lattice, own.min) && to_lattice(lattice, own.max)) continue;
    throw Error({.file = source.path().string(),
                 .problem = "too far away for the lattice of " + first->path().string(),
                 .found = fmt::format("a box from {} to {}", text_of(own.min), text_of(own.max))});
  }
  return lattice;
}

Crs common_crs(const std::vector<CloudSource>& sources) {
  const CloudSource* const first = first_that_binds(sources, has_crs);
  if (first == nullptr) return {};
  const Crs& crs = first->facts.crs;
  ComparedSystems compared(crs);
  std::size_t agreeing = 0, differing = 0;
  const CloudSource* odd = nullptr;
  for (const CloudSource& source : sources) {
    if (!has_crs(source) || source.point_count() == 0) continue;
    if (compared.with(source.facts.crs) != CrsAgreement::different) {
      ++agreeing;
    } else if (differing++ == 0) {
      odd = &source;
    }
  }
  if (odd != nullptr && agreeing < differing) reject_crs(*first, *odd);
  if (odd != nullptr) reject_crs(*odd, *first);
  check_heights(sources);
  return crs;
}

bool JoinedRecords::Order::operator()(std::size_t a, std::size_t b) const {
  const auto key = [this](std::size_t index) {
    const VariableLengthRecord& record = (*records)[index];
    return std::tie(record.record_id, record.user_id, record.description, record.extended, record.data);
  };
  return key(a) < key(b);
}

void JoinedRecords::join(std::size_t first) {
  std::size_t kept = first;
  for (std::size_t i = first; i < records_.size(); ++i) {
    if (earlier_.contains(i)) continue;
    if (kept != i) records_[kept] = std::move(records_[i]);
    ++kept;
  }
  records_.resize(kept);
  for (std::size_t i = first; i < kept; ++i) earlier_.insert(i);
}

// The resolution of floats at the size of the coordinates does not matter: far from the origin it is
// centimetres.
void warn_of_rounding(const CloudSource& source, PointCloud& cloud) {
  constexpr double k_matters = 1e-6;
  if (source.has_lattice || source.point_count() == 0) return;
  const glm::dvec3 sides = source.survey.bounds.max - source.survey.bounds.min;
  const double longest = std::max({sides.x, sides.y, sides.z});
  for (int axis = 0; axis < 3; ++axis) {
    const double resolution = source.survey.resolution[axis];
    const double rounding = 0.5 * cloud.lattice.scale[axis];
    if (resolution == 0.0 || rounding <= std::max(resolution * (1 + 1e-9), k_matters * longest)) continue;
    cloud.warnings.push_back(fmt::format("{}: coordinates are rounded to steps of {}", source.path().string(),
                                         cloud.lattice.scale[axis]));
    return;
  }
}

void warn_of_heights(std::span<const CloudSource> sources, PointCloud& cloud) {
  std::map<std::string, SomeFiles> files;
  for (const CloudSource& source : sources)
    if (!source.facts.heights_note.empty() && source.point_count() > 0)
      files[source.facts.heights_note].add(source.path().string());
  for (const auto& [note, some] : files) cloud.warnings.push_back(some.text() + ": " + note);
}

void warn_of_lattices(std::span<CloudSource> sources, PointCloud& cloud) {
  SomeFiles files;
  for (CloudSource& source : sources) {
    if (!source.has_lattice || source.point_count() == 0) continue;
    source.is_rounded = !steps_between(*source.reader->lattice(), cloud.lattice);
    if (source.is_rounded) files.add(source.path().string());
  }
  if (files.count() == 0) return;
  cloud.warnings.push_back(
      fmt::format("{}: coordinates are rounded to steps of {}: no lattice holds those of all files exactly",
                  files.text(), text_of(cloud.lattice.scale)));
}

void warn_of_gaps(std::span<const GivenRows> given, AttributeSet present,
                  std::vector<std::string>& warnings) {
  // By missing attributes, in the order of the files.
  std::vector<std::pair<AttributeSet, SomeFiles>> gaps;
  for (const GivenRows& rows : given) {
    AttributeSet missing;
    missing.bits = present.bits & ~rows.attributes.bits;
    if (missing.bits == 0 || rows.point_count == 0) continue;
    const auto same = std::ranges::find(gaps, missing, &std::pair<AttributeSet, SomeFiles>::first);
    SomeFiles& files = same != gaps.end() ? same->second : gaps.emplace_back(missing, SomeFiles{}).second;
    files.add(rows.file_name);
  }
  for (const auto& [missing, files] : gaps) {
    warnings.push_back(
        fmt::format("{}: no {}; using 0", files.text(), fmt::join(attribute_names(missing), ", ")));
  }
}

void warn_of_missing_crs(std::span<const CloudSource> sources, PointCloud& cloud) {
  if (cloud.crs.empty()) return;
  SomeFiles files;
  for (const CloudSource& source : sources) {
    if (source.is_open && source.facts.crs.empty() && source.point_count() > 0)
      files.add(source.path().string());
  }
  if (files.count() == 0) return;
  cloud.warnings.push_back(
      fmt::format("{}: no coordinate reference system; assuming that of the other files, {}", files.text(),
                  crs_name(cloud.crs)));
}

void warn_of_other_crs(std::span<const CloudSource> sources, PointCloud& cloud) {
  std::vector<std::pair<std::string, SomeFiles>> ways;
  ComparedSystems compared(cloud.crs);
  for (const CloudSource& source : sources) {
    const Crs& own = source.facts.crs;
    if (own.empty() || source.point_count() == 0) continue;
    if (compared.with(own) != CrsAgreement::unknown) continue;
    const std::string name = crs_name(own);
    const auto same = std::ranges::find(ways, name, &std::pair<std::string, SomeFiles>::first);
    SomeFiles& files = same != ways.end() ? same->second : ways.emplace_back(name, SomeFiles{}).second;
    files.add(source.path().string());
  }
  for (const auto& [name, files] : ways) {
    cloud.warnings.push_back(fmt::format(
        "{}: the coordinate reference system is described differently ({}) from the other files ({}), "
        "whose description is kept",
        files.text(), name, crs_name(cloud.crs)));
  }
}

void warn_of_losses(const CloudReader& reader, std::vector<CloudFile>& files, PointCloud& cloud) {
  constexpr std::size_t k_most_reported = 10;
  const std::vector<LostPoints> lost = reader.lost();
  const std::string file = reader.file().path.string();
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < lost.size(); ++i) {
    count += lost[i].count;
    if (i >= k_most_reported) continue;
    const std::string location = lost[i].location.empty() ? "" : ":" + lost[i].location;
    cloud.warnings.push_back(fmt::format("{}{}: {}; {} lost", file, location, lost[i].problem,
                                         lost[i].count == 0   ? std::string("an unknown number of points is")
                                         : lost[i].count == 1 ? std::string("1 point is")
                                                              : fmt::format("{} points are", lost[i].count)));
  }
  if (lost.size() > k_most_reported) {
    cloud.warnings.push_back(fmt::format("{}: corrupt in {} more locations; {} points are lost in total",
                                         file, lost.size() - k_most_reported, count));
  }
  if (!files.empty()) files.front().lost_count = count;
}

void warn_of_twins(const CloudInputs& inputs, PointCloud& cloud) {
  std::set<std::pair<dev_t, ino_t>> known;
  SomeFiles twins;
  for (const CloudInput& input : inputs.inputs) {
    struct stat status {};
    if (input.memory || ::stat(input.name.c_str(), &status) != 0) continue;
    if (!known.emplace(status.st_dev, status.st_ino).second) twins.add(input.name.string());
  }
  if (twins.count() > 0)
    cloud.warnings.push_back(twins.text() + ": given more than once; its points are repeated");
  warn_of_copies(cloud);
}

}  // namespace alidade
