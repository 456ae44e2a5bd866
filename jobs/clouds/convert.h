// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "base/bounds.h"
#include "cloud/read_cloud.h"
#include "jobs/cloud_formats.h"
#include "jobs/cloud_request.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"

namespace alidade::jobs {

/// A cloud as one file of another format, that of the output's extension, thinned or with normals. `memory`:
/// bytes for points, 4 GiB by default; those of a larger cloud are kept beside the output.
struct ConvertRequest : CloudRequest {
  std::uint64_t every = 1;        ///< keep_every()
  std::optional<double> spacing;  ///< thin()
  bool normals = false;           ///< of the surfaces around the points
  ColorDepth color_depth = ColorDepth::automatic;
  CloudStores stores = make_stores();  ///< with the settings of formats that extensions add
};

/// Declares all fields.
void add_convert_fields(const Fields& fields, ConvertRequest& request);

/// A checked request.
using ConvertPlan = Plan<ConvertRequest>;

/// Errors: an output of an unknown format, that is an input, or that cannot be replaced or written; settings
/// of one format for another; a spacing or normals where x and y have another unit than heights.
ConvertPlan plan(const ConvertRequest& request);

/// What was written.
struct ConvertResult {
  std::uint64_t point_count = 0;
  std::uint64_t input_count = 0;  ///< points of the files, before any selection
  std::optional<Bounds> bounds;   ///< empty if points went from file to file: LAS to LAZ, or to a CloudStore
};

/// Reads the cloud, thins it, measures normals, writes the file, and notes how many points it has. If nothing
/// changes but how a LAS file is packed, all else is kept (repack_las()). The output does not depend on
/// `memory`. Errors: those of reading and of the format's writer. Cancelled.
ConvertResult run(const ConvertPlan& plan, Listener& listener);

}  // namespace alidade::jobs
