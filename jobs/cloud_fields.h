// SPDX-License-Identifier: MIT
#pragma once

#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>

#include "base/input_file.h"
#include "cloud/cloud_inputs.h"
#include "cloud/input_view.h"
#include "jobs/fields.h"

// The fields of jobs that read clouds: which clouds, which of their points, in which reference system.

namespace alidade::jobs {

struct SystemChoice;

/// Which points of the clouds of a request are wanted, and in which reference system. Copies refer to the
/// same. Made by add_view_fields().
struct CloudView {
  std::shared_ptr<InputView> view;
  std::shared_ptr<SystemChoice> systems;

  /// The clouds with this view, which is complete once all fields were read.
  CloudInputs apply(CloudInputs clouds) const;
};

/// Whether a job measures, so that heights must be in the unit of x and y, or shows clouds as they are.
enum class HeightUse { measured, as_stored };

/// Declares --classes, --ignore-classes, --where, --crop, --crop-crs, --columns, --crs, --reproject and
/// --vertical-unit, except those of the classes in `own`, which the job declares itself, then those of
/// add_remote_fields() (jobs/remote_files.h).
CloudView add_view_fields(const Fields& fields, std::initializer_list<std::string_view> own = {},
                          HeightUse height_use = HeightUse::measured);

/// Beginning and end of the help of a cloud's files.
inline const std::string k_files_help =
    "cloud files, folders or patterns such as 'tiles/*.las', joined into one cloud";
std::string database_help();

/// Declares the field that takes the files of a cloud; folders and patterns are expanded (resolve_clouds())
/// when it is read. Errors then: those of resolve_clouds().
Field add_cloud_files(const Fields& fields, const std::string& name, const std::string& kind,
                      const std::string& help, CloudInputs& clouds, const CloudView& view);

/// Declares the operand that names the cloud, which is required, and add_view_fields() without those that the
/// job has itself.
void add_cloud(const Fields& fields, CloudInputs& files, std::initializer_list<std::string_view> own = {});

/// Declares --partial: ReadOptions::partial.
Field add_partial(const Fields& fields, bool& partial);

}  // namespace alidade::jobs
