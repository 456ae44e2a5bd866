// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "base/scratch_file.h"
#include "cloud/cloud_inputs.h"
#include "cloud/large_cloud.h"
#include "cloud/read_cloud.h"
#include "jobs/fields.h"
#include "jobs/listener.h"

// Clouds larger than memory, which an extension holds. Without it, all clouds are held in memory.

namespace alidade::jobs {

struct IndexRequest;

/// What the extension does.
struct LargeClouds {
  ReadLargeCloud read = nullptr;
  /// Declares --memory of 'index', and fields that need it.
  void (*add_index_fields)(const Fields& fields, IndexRequest& request) = nullptr;
  /// The part of plan() that checks these.
  void (*check_index)(const IndexRequest& request) = nullptr;
  /// read() as one stage, by these fields. LargeCloud::finish() is to be called when the index is written.
  std::unique_ptr<LargeCloud> (*read_for_index)(const IndexRequest& request, const ReadOptions& options,
                                                const ScratchSpace& scratch, Listener& listener) = nullptr;
};
/// Names it, before fields are declared.
void set_large_clouds(const LargeClouds& clouds);
/// Null without the extension.
const LargeClouds* large_clouds();

/// Declares --memory of jobs that load_cloud() with scratch_beside(); nothing without the extension.
std::optional<Field> add_scratch_memory(const Fields& fields, std::optional<std::size_t>& memory);
/// Scratch files next to an output, or in the current folder if `output` is empty. Empty without --memory.
/// Errors: --memory without the extension.
std::optional<ScratchSpace> scratch_beside(const std::filesystem::path& output,
                                           std::optional<std::size_t> memory);

/// A cloud in memory, or a large one.
using HeldCloud = std::variant<PointCloud, std::unique_ptr<LargeCloud>>;

/// Reads the files of a cloud as one stage, into scratch files if there is room for them. Warns of nothing.
/// `progress` of the options is ignored. Errors: those of read_cloud(), or of LargeClouds::read.
HeldCloud hold_cloud(const CloudInputs& files, ReadOptions options,
                     const std::optional<ScratchSpace>& scratch, Listener& listener);
/// Null if it is in memory.
LargeCloud* large_of(const HeldCloud& cloud);
const PointCloud& facts_of(const HeldCloud& cloud);
PointColumns points_of(HeldCloud& cloud);

/// Whether as many points will be read as the files state.
bool knows_point_count(const CloudInputs& files, bool partial, const StatedSize& stated);

/// States that temporary files take up to so many bytes of a folder. Errors: there is no room for them.
void check_room(const std::filesystem::path& folder, std::uint64_t bytes, Listener& listener);

}  // namespace alidade::jobs
