// SPDX-License-Identifier: MIT
#include "cloud/joined_files.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <array>
#include <glm/common.hpp>
#include <map>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "base/error.h"
#include "cloud/crs.h"
#include "cloud/lattice.h"

namespace alidade {
namespace {

std::string text_of(const glm::dvec3& value) {
  return fmt::format("{}, {}, {}", value.x, value.y, value.z);
}

bool has_lattice(const CloudSource& source) {
  return source.has_lattice();
}

bool has_crs(const CloudSource& source) {
  return !source.facts.crs.empty();
}

/// The first source that has a property which all must share: one with points, if there is any.
template <class Has>
const CloudSource* first_that_binds(std::span<const CloudSource> sources, const Has& has) {
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

Lattice common_lattice(std::span<const CloudSource> sources) {
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
    return with_file(farthest == sources.end() ? "" : farthest->name(), [&] { return fit_lattice(surveys); });
  }
  std::vector<Lattice> lattices = {*first->facts.lattice};
  Bounds bounds;
  for (const CloudSource& source : sources) {
    if (source.point_count() == 0) continue;
    bounds.grow(source.has_lattice() ? source.facts.box.value_or(Bounds()) : source.survey.bounds);
    if (source.has_lattice()) lattices.push_back(*source.facts.lattice);
  }
  const Lattice lattice = joined_lattice(lattices, bounds);
  for (const CloudSource& source : sources) {
    if (source.has_lattice() || source.point_count() == 0) continue;
    const Bounds& own = source.survey.bounds;
    if (to_lattice(lattice, own.min) && to_lattice(lattice, own.max)) continue;
    throw Error({.file = source.name(),
                 .problem = "too far away for the lattice of " + first->name(),
                 .found = fmt::format("a box from {} to {}", text_of(own.min), text_of(own.max))});
  }
  return lattice;
}

[[noreturn]] void reject_crs(const CloudSource& odd, const CloudSource& other) {
  throw file_error(odd.facts.file.path,
                   "the coordinate reference system differs from that of " + other.name(),
                   crs_name(other.facts.crs) + " (alidade convert --reproject SYSTEM brings files to one)",
                   crs_name(odd.facts.crs));
}

/// Errors and warnings: see join_facts().
void join_systems(std::span<const CloudSource> sources, PointCloud& cloud) {
  const CloudSource* const first = first_that_binds(sources, has_crs);
  if (first == nullptr) return;
  cloud.crs = first->facts.crs;
  ComparedSystems compared(cloud.crs);
  const CloudSource *odd = nullptr, *converted = nullptr, *unstated = nullptr;
  std::size_t agreeing = 0, differing = 0;
  Remarks without, unclear;
  for (const CloudSource& source : sources) {
    if (!converted && !source.facts.heights_note.empty()) converted = &source;
    if (source.point_count() == 0) continue;
    if (!has_crs(source)) {
      if (!source.reader) continue;
      if (!unstated) unstated = &source;
      without.add("no coordinate reference system; assuming that of the other files, " + crs_name(cloud.crs),
                  source.name());
      continue;
    }
    const CrsAgreement agreement = compared.with(source.facts.crs);
    ++(agreement == CrsAgreement::different ? differing : agreeing);
    if (agreement == CrsAgreement::different && !odd) odd = &source;
    if (agreement == CrsAgreement::unknown)
      unclear.add(fmt::format("the coordinate reference system is described differently ({}) from the other "
                              "files ({}), whose description is kept",
                              crs_name(source.facts.crs), crs_name(cloud.crs)),
                  source.name());
  }
  if (odd != nullptr && agreeing < differing) reject_crs(*first, *odd);
  if (odd != nullptr) reject_crs(*odd, *first);
  if (converted != nullptr && unstated != nullptr)
    throw file_error(unstated->facts.file.path,
                     "no coordinate reference system, and the heights of " + converted->name() +
                         " are converted to the unit of x and y",
                     "--crs EPSG:n, which states one");
  without.write(cloud.warnings);
  unclear.write(cloud.warnings);
}

/// Errors and warnings: see join_facts().
void join_times(std::span<const CloudSource> sources, AttributeSet wanted, PointCloud& cloud) {
  const CloudSource* timed = nullptr;
  for (const CloudSource& source : sources) {
    const std::optional<bool> is_standard = source.facts.gps_time_is_standard;
    const bool has_times = source.point_count() > 0 && source.facts.attributes.contains(Attribute::gps_time);
    if (!is_standard || !has_times) continue;
    if (timed == nullptr) {
      timed = &source;
      cloud.gps_time_is_standard = *is_standard;
    } else if (cloud.gps_time_is_standard != *is_standard && wanted.contains(Attribute::gps_time)) {
      cloud.warnings.push_back(fmt::format(
          "{}: the GPS time system (week or standard) differs from that of {}; times are not comparable",
          source.name(), timed->name()));
    }
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

void Remarks::add(const std::string& remark, const std::string& file) {
  const auto same = std::ranges::find(remarks_, remark, &std::pair<std::string, SomeFiles>::first);
  (same != remarks_.end() ? *same : remarks_.emplace_back(remark, SomeFiles{})).second.add(file);
}

void Remarks::write(std::vector<std::string>& warnings) const {
  for (const auto& [remark, files] : remarks_) warnings.push_back(files.text() + ": " + remark);
}

bool is_rounded(const CloudSource& source, const Lattice& lattice) {
  return source.has_lattice() && source.point_count() > 0 && !steps_between(*source.facts.lattice, lattice);
}

void join_facts(std::span<const CloudSource> sources, AttributeSet wanted, PointCloud& cloud) {
  cloud.lattice = common_lattice(sources);
  join_systems(sources, cloud);
  if (!sources.empty()) {
    const FileFacts& first = sources.front().facts;
    cloud.gps_time_is_standard = first.gps_time_is_standard.value_or(false);
    cloud.project_id = first.project_id;
    cloud.file_source_id = first.file_source_id;
  }
  Remarks heights, rounded;
  for (const CloudSource& source : sources) {
    if (!source.facts.heights_note.empty() && source.point_count() > 0)
      heights.add(source.facts.heights_note, source.name());
    if (is_rounded(source, cloud.lattice))
      rounded.add(
          fmt::format("coordinates are rounded to steps of {}: no lattice holds those of all files exactly",
                      text_of(cloud.lattice.scale)),
          source.name());
  }
  heights.write(cloud.warnings);
  rounded.write(cloud.warnings);
  join_times(sources, wanted, cloud);
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
