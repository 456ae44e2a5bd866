// SPDX-License-Identifier: MIT
#include "database/sqlite/file_cloud.h"

#include <sys/stat.h>

#include "base/error.h"
#include "base/input_file.h"
#include "cloud/input_view.h"
#include "octree/index_file/index_file.h"

namespace alidade::database {

FileCloud::FileCloud(std::span<const std::filesystem::path> names, const FileTables& how) {
  const CloudInputs inputs = in_one_unit(resolve_clouds(names, index_and_file_formats()));
  for (const CloudInput& input : inputs.inputs) files_.push_back(state_of(input.name));
  const CloudInput* const copc = how.reading.partial ? nullptr : inputs.only(k_copc_format);
  if (copc != nullptr) chunks_ = copc_chunks(*copc, how.is_given_up);
  if (schema().point_count == 0) chunks_ = octree_chunks(inputs, how.reading);
  check_unchanged();
}

FileCloud::FileState FileCloud::state_of(const std::filesystem::path& file) {
  struct stat status {};
  // A missing file has the default state.
  if (is_remote_name(file.string()) || ::stat(file.c_str(), &status) != 0) return {.name = file};
  return {.name = file,
          .device = status.st_dev,
          .number = status.st_ino,
          .size = static_cast<std::uint64_t>(status.st_size),
          .seconds = status.st_mtim.tv_sec,
          .nanoseconds = status.st_mtim.tv_nsec};
}

void FileCloud::check_unchanged() const {
  for (const FileState& file : files_) {
    const FileState now = state_of(file.name);
    if (now == file) continue;
    throw file_error(file.name.string(),
                     now.number == 0 ? "the file was removed since it was opened"
                                     : "the file has changed since it was opened",
                     "the file as it was when it was opened; make the table or statement again");
  }
}

}  // namespace alidade::database
