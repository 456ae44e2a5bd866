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
/// add_remote_fields().
CloudView add_view_fields(const Fields& fields, std::initializer_list<std::string_view> own = {},
                          HeightUse height_use = HeightUse::measured);

/// Beginning and end of the help of a cloud's files.
inline const std::string k_files_help =
    "cloud files, folders or patterns such as 'tiles/*.las', joined into one cloud";
inline const std::string k_database_help =
    "; or a table of a database: site.db?table=NAME or postgresql://HOST/DATABASE?table=NAME";

/// Declares the field that takes the files of a cloud; folders and patterns are expanded (resolve_clouds())
/// when it is read. Errors then: those of resolve_clouds().
Field add_cloud_files(const Fields& fields, const std::string& name, const std::string& kind,
                      const std::string& help, CloudInputs& clouds, const CloudView& view);

/// Declares the operand that names the cloud, which is required, and add_view_fields() without those that the
/// job has itself.
void add_cloud(const Fields& fields, CloudInputs& files, std::initializer_list<std::string_view> own = {});

/// Declares --partial: ReadOptions::partial.
Field add_partial(const Fields& fields, bool& partial);

/// Declares --cache, --allow-host, --cache-size and --yes, which hold for the process: open_remote().
void add_remote_fields(const Fields& fields);

/// Who waits for remote files, and is told and asked. Functions that are missing do nothing, and say no.
struct RemoteUser {
  bool (*is_interrupted)() = nullptr;  ///< as geo::RemoteOptions has it
  void (*note)(const std::string& text) = nullptr;
  bool (*confirm)(const std::string& question) = nullptr;
};

/// Opens a remote file as add_remote_fields() states, by default with the cache of the environment variable
/// ALIDADE_CACHE; for set_remote_files(). Before a file is fetched whole (RemoteFile::map()) the user is told
/// its size, and asked if the process would have fetched more than 1 GB of such files, unless --yes is given:
/// without a yes, map() is an Error. Errors: as geo::open_remote_file().
std::unique_ptr<RemoteFile> open_remote(const std::string& name, const RemoteUser& user);

}  // namespace alidade::jobs
