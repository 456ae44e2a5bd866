// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <variant>

#include "base/progress.h"
#include "base/scratch_file.h"
#include "cloud/cloud_inputs.h"
#include "cloud/crs.h"
#include "cloud/read_cloud.h"
#include "cloud/scratch_cloud.h"
#include "jobs/cloud_formats.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "octree/index_file/index_file.h"

namespace alidade::jobs {

/// Reads the files of a cloud, or loads them with an octree, each as one stage; warns of what the cloud warns
/// of. `partial`: damaged files are read in part; that and `progress` of the options are ignored.
PointCloud read_files(const CloudInputs& files, bool partial, ReadOptions options, Listener& listener);
IndexedCloud load_cloud(const CloudInputs& files, bool partial, IndexCloudOptions options,
                        Listener& listener);

/// A cloud in memory, or in scratch files if memory might not hold it.
using HeldCloud = std::variant<PointCloud, ScratchCloud>;

/// Reads the files of a cloud as one stage, into scratch files if there is room for them. Warns of nothing.
/// `progress` of the options is ignored. Errors: those of read_cloud(), or of ScratchCloud.
HeldCloud hold_cloud(const CloudInputs& files, ReadOptions options,
                     const std::optional<ScratchSpace>& scratch, Listener& listener,
                     ScratchCheckpoint* checkpoint = nullptr);
const PointCloud& facts_of(const HeldCloud& cloud);
PointColumns points_of(HeldCloud& cloud);

/// Reads files and then stores their points: two stages, the second one called `storing`; warns of what the
/// cloud warns of. `memory`: bytes for points. `progress` of the options is ignored.
database::StoredFiles store_in_stages(const CloudInputs& files, ReadOptions options, std::uint64_t memory,
                                      const std::string& storing, const OpenStore& output,
                                      Listener& listener);

/// Declares --memory of jobs and commands that can hold clouds in scratch files.
Field add_scratch_memory(const Fields& fields, std::optional<std::size_t>& memory);
/// Scratch files next to an output, or in the current folder if `output` is empty. Empty without --memory.
std::optional<ScratchSpace> scratch_beside(const std::filesystem::path& output,
                                           std::optional<std::size_t> memory);

/// Whether as many points will be read as the files state.
bool knows_point_count(const CloudInputs& files, bool partial, const StatedSize& stated);

/// States that temporary files take up to so many bytes of a folder. Errors: there is no room for them.
void check_room(const std::filesystem::path& folder, std::uint64_t bytes, Listener& listener);

/// with_spacings() and with_surfaces(), each as one stage.
Octree with_spacings(const Octree& octree, int neighbours, Listener& listener);
Octree with_surfaces(const Octree& octree, Listener& listener);

/// Errors: x and y of a cloud are degrees, and z is a length: distances are undefined, so that images would
/// be hairlines and answers about sight wrong.
void check_map_unit(const Crs& crs, const CloudInputs& clouds);

}  // namespace alidade::jobs
