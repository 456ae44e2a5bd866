// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cloud/cloud_inputs.h"
#include "octree/octree.h"

namespace alidade::jobs {

/// What a job will read, write and need, as far as that is known before a point is read.
struct PlannedWork {
  CloudInputs clouds{};
  bool partial = false;                         ///< damaged clouds are read in part
  std::vector<std::filesystem::path> reads{};   ///< other files; empty names count as none
  std::vector<std::filesystem::path> writes{};  ///< empty names count as none
  /// Memory at the peak, as measured: for each point of the clouds, and beside them. 0 for each point: it
  /// does not depend on them.
  double bytes_per_point = 0.0;
  double bytes_beside = 50e6;  ///< libraries, threads, buffers
};

/// check_outputs() (jobs/outputs.h) for files of this work.
void check_outputs(const PlannedWork& work, bool overwrite);

/// The work in lines for people, such as "reads   site.las   1000000 points, 38 MB". Opens clouds to count
/// their points. Errors: those of open_stored_cloud(), also damage without `partial`; a file that is missing.
std::string text_of(const PlannedWork& work);

/// How the points of the octree lie that is used as it is stored: that of a single index file. Empty: one is
/// built. Opens the file.
std::optional<Organisation> stored_organisation(const CloudInputs& clouds);

/// A checked request. Only the plan() of the request makes one: what is made otherwise was not checked.
template <class Request>
class Plan {
 public:
  Plan(Request request, PlannedWork work) : request_(std::move(request)), work_(std::move(work)) {}

  const Request& request() const { return request_; }
  const PlannedWork& work() const { return work_; }

 private:
  Request request_;
  PlannedWork work_;
};

}  // namespace alidade::jobs
