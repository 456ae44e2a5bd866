// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "jobs/cloud_request.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"
#include "renderer/merge_parts.h"

namespace alidade::jobs {

/// The parts of an image that machines have rendered (RenderRequest::part), to be joined into the output,
/// or only returned without one.
struct MergeRequest : JobRequest {
  std::vector<std::filesystem::path> parts;
};

/// Declares all fields.
void add_merge_fields(const Fields& fields, MergeRequest& request);

using MergePlan = Plan<MergeRequest>;

/// Errors: an output that is no image, a part, or cannot be written; those of renderer::check_parts().
MergePlan plan(const MergeRequest& request);

/// Writes the image, and returns it; warns if it shows no surface. Errors: those of renderer::merge_parts()
/// and image::write_image().
renderer::MergedImage run(const MergePlan& plan, Listener& listener);

}  // namespace alidade::jobs
