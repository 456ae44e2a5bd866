// SPDX-License-Identifier: MIT
#include "extensions/change/tests/changed_courtyard.h"

#include <gtest/gtest.h>

#include <array>

#include "octree/build.h"

namespace alidade::test {
namespace {

using namespace visibility;

struct Recall {
  std::size_t right = 0, all = 0;
  double share() const { return static_cast<double>(right) / static_cast<double>(all); }
};

/// By class: how many points of surfaces that are scanned well are called what is true of them.
std::array<Recall, k_change_classes> recalls(const PointCloud& cloud, const TrueChanges& truth,
                                             const PointChanges& found) {
  constexpr double k_least_density = 0.05;  // beams 0.02 radians apart are 0.4 m apart
  std::array<Recall, k_change_classes> recalls;
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    const int what = cloud.classifications[id];
    const bool is_crown = what == 3 || what == 5;
    if (is_crown || (truth.densities[id] > 0.0 && truth.densities[id] < k_least_density)) continue;
    Recall& recall = recalls[static_cast<std::size_t>(truth.classes[id])];
    ++recall.all;
    recall.right += found.classes[id] == truth.classes[id] ? 1 : 0;
  }
  return recalls;
}

TEST(ChangedCourtyard, classes_are_those_of_exact_lines) {
  const ChangedCourtyard site = changed_courtyard();
  const PointCloud before = scan_of(site.before, 250'000, 1), after = scan_of(site.after, 250'000, 2);
  const Occluders old_occluders(build(before), {}), new_occluders(build(after), {});
  constexpr double k_max_distance = 0.15;
  const Changes changes =
      find_changes({old_occluders, site.before.stations}, {new_occluders, site.after.stations},
                   {.registration_error = 0.001, .max_distance = k_max_distance});
  const auto gone =
      recalls(before, true_changes(site.before, before, site.after, k_max_distance, ChangeClass::gone),
              changes.before);
  const auto come =
      recalls(after, true_changes(site.after, after, site.before, k_max_distance, ChangeClass::appeared),
              changes.after);
  // With edges; docs/reports/change_evaluation.md has figures for denser scans without them.
  EXPECT_GT(gone[static_cast<std::size_t>(ChangeClass::same)].share(), 0.97);
  EXPECT_GT(gone[static_cast<std::size_t>(ChangeClass::moved)].share(), 0.9);
  EXPECT_GT(gone[static_cast<std::size_t>(ChangeClass::gone)].share(), 0.85);
  EXPECT_GT(come[static_cast<std::size_t>(ChangeClass::same)].share(), 0.97);
  EXPECT_GT(come[static_cast<std::size_t>(ChangeClass::appeared)].share(), 0.85);
  EXPECT_GT(come[static_cast<std::size_t>(ChangeClass::never_seen)].share(), 0.5);
}

}  // namespace
}  // namespace alidade::test
