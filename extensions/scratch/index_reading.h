// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "base/scratch_file.h"
#include "cloud/large_cloud.h"
#include "cloud/read_cloud.h"
#include "jobs/clouds/index.h"
#include "jobs/fields.h"
#include "jobs/listener.h"

// What LargeClouds (jobs/large_clouds.h) needs for 'alidade index', whose reading can resume.

namespace alidade::jobs {

void add_reading_fields(const Fields& fields, IndexRequest& request);

/// Errors: the checkpoint is or holds the output, holds an input, exists and may neither be resumed from nor
/// replaced, or is another folder; an input is a table of a database, whose changes would not be detected.
void check_reading(const IndexRequest& request);

/// Notes what it resumes from and what the disk has to hold; unless the cloud is finished, how to resume.
/// Errors: those of reading; no room for temporary files; those of ScratchCheckpoint. Cancelled.
std::unique_ptr<LargeCloud> read_for_index(const IndexRequest& request, const ReadOptions& options,
                                           const ScratchSpace& scratch, Listener& listener);

}  // namespace alidade::jobs
