// SPDX-License-Identifier: MIT
#pragma once

#include <bitset>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "cloud/cloud_inputs.h"
#include "cloud/crs.h"
#include "extensions/change/change.h"
#include "jobs/cloud_request.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"
#include "jobs/write_points.h"

namespace alidade::jobs {

/// One of the two epochs.
struct EpochRequest {
  const char* name;          ///< "BEFORE"
  const char* option;        ///< "--origin-before"
  const char* files_option;  ///< "--origins-before"
  CloudInputs files{};
  std::vector<glm::dvec3> origins{};
  std::filesystem::path origins_file{};  ///< empty: none
};

/// What has changed between two scans of one site.
struct ChangeRequest : JobRequest {
  EpochRequest before{"BEFORE", "--origin-before", "--origins-before"};
  EpochRequest after{"AFTER", "--origin-after", "--origins-after"};
  visibility::ChangeOptions options;
  std::bitset<256> ignored_classes = std::bitset<256>{}.set(7).set(18);
  bool no_sight = false;
};

/// Declares all fields. `add_answers` declares those of whoever shows the result, where the manual has them.
void add_change_fields(
    const Fields& fields, ChangeRequest& request, const std::function<void()>& add_answers = [] {});

/// A checked request.
using ChangePlan = Plan<ChangeRequest>;

/// Checks all that can be checked before a point is read. Errors: an output of an unknown format, or that
/// cannot be replaced or written.
ChangePlan plan(const ChangeRequest& request);

/// The findings of one epoch.
struct EpochResult {
  visibility::PointChanges points;
  std::vector<visibility::ChangeSummary> classes;  ///< in the order of visibility::ChangeClass
  Crs crs;
};

struct ChangeResult {
  EpochResult before, after;
};

/// The columns that the output has beside those of the cloud of an epoch, 1 or 2. `changes` must outlive
/// them.
std::vector<ResultColumn> columns_of(const visibility::PointChanges& changes, std::uint8_t epoch);

/// Compares the clouds, and writes the points of both where the request has an output. Errors: those of
/// load_cloud() and check_map_unit(); an empty cloud; unknown scanner positions without `no_sight`; clouds in
/// different reference systems; those of visibility::find_changes(); Cancelled. Memory: both clouds, their
/// surfaces, and that of visibility::find_changes().
ChangeResult run(const ChangePlan& plan, Listener& listener);

}  // namespace alidade::jobs
