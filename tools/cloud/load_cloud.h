// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "base/progress.h"
#include "base/scratch_file.h"
#include "cloud/cloud_inputs.h"
#include "cloud/read_cloud.h"
#include "database/point_filter.h"
#include "database/point_stream.h"
#include "octree/index_file/index_file.h"
#include "tools/options.h"

namespace alidade::tools {

/// All formats that the program reads: tables of servers, SQLite, index files, and those of files.
CloudFormats cloud_formats();

/// Reads the files of a request, or loads them with an octree; shows progress and prints the warnings of the
/// cloud. `partial` and `progress` of the options are ignored.
PointCloud read_shown(const CloudRequest& request, ReadOptions options);
IndexedCloud load_shown(const CloudRequest& request, IndexCloudOptions options);

/// Declares --memory of commands that can hold clouds in scratch files.
Option add_scratch_memory(const Options& command, std::optional<std::size_t>& memory);
/// Scratch files next to an output, or in the current folder if `output` is empty. Empty without --memory.
std::optional<ScratchSpace> scratch_beside(const std::filesystem::path& output,
                                           std::optional<std::size_t> memory);

/// States that temporary files take up to so many bytes of a folder. Errors: there is no room for them.
void check_room(const std::filesystem::path& folder, std::uint64_t bytes, Verbosity verbosity);

/// Does `work`, which reads files and then stores points, with a progress line for each; prints its warnings.
/// `storing` is the text of the second line.
database::StoredFiles store_shown(
    const RunRequest& request, ColorDepth color_depth, const std::string& storing,
    const std::function<database::StoredFiles(const ReadOptions& reading, const Progress& storing)>& work);

/// with_spacings() and with_surfaces(), with progress.
Octree with_spacings_shown(const Octree& octree, int neighbours, Verbosity verbosity);
Octree with_surfaces_shown(const Octree& octree, Verbosity verbosity);

/// Whether a part of a cloud can be read from its database: 'alidade sql load' has stored it, and no option
/// changes its points. Errors: those of opening a table on a server.
bool has_parts(const CloudInput& input);

/// Errors: x and y of a cloud are degrees, and z is a length: distances are undefined, so that images would
/// be hairlines and answers about sight wrong.
void check_map_unit(const Crs& crs, const CloudInputs& clouds);

/// The unit of parts of a cloud in a database: "chunks" of SQLite, "points" of a server.
const char* part_unit(const CloudInput& input);

/// Reads those points of a cloud in a database that are needed: at least all for which a filter holds
/// (database/sqlite/stored_cloud.h, database/server/server_clouds.h). Requires has_parts(input).
database::CloudPart read_database_part(const CloudInput& input, std::span<const database::PointFilter> any_of,
                                       AttributeSet attributes, const Progress& progress);

/// "chunks read" or "points read", as a line of a table.
std::string part_table(const database::CloudPart& part);

}  // namespace alidade::tools
