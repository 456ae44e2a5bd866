// SPDX-License-Identifier: MIT
#include "jobs/large_clouds.h"

#include <fmt/format.h>
#include <algorithm>
#include <system_error>

#include "base/error.h"
#include "base/shown_text.h"

namespace alidade::jobs {
namespace {

std::optional<LargeClouds> extension;

}  // namespace

void set_large_clouds(const LargeClouds& clouds) {
  extension = clouds;
}

const LargeClouds* large_clouds() {
  return extension ? &*extension : nullptr;
}

std::optional<Field> add_scratch_memory(const Fields& fields, std::optional<std::size_t>& memory) {
  if (!extension) return std::nullopt;
  return fields.value(
      "--memory", "SIZE",
      "for clouds larger than memory: hold the points in temporary files next to the output, without "
      "an output in the current folder, and sort them in so much memory, bytes or a number with k, M, G "
      "or T, at least 1M; the output is the same",
      memory, parse_memory);
}

std::optional<ScratchSpace> scratch_beside(const std::filesystem::path& output,
                                           std::optional<std::size_t> memory) {
  if (!memory) return std::nullopt;
  if (!extension) throw input_error("--memory requires the extension scratch", "a program with it");
  const std::filesystem::path folder = output.parent_path();
  return ScratchSpace{folder.empty() ? "." : folder, *memory};
}

HeldCloud hold_cloud(const CloudInputs& files, ReadOptions options,
                     const std::optional<ScratchSpace>& scratch, Listener& listener) {
  return in_stage(listener, "reading", "B", [&](const Progress& progress) -> HeldCloud {
    options.progress = progress;
    if (scratch) return extension->read(files, options, *scratch);
    return read_cloud(files, options);
  });
}

LargeCloud* large_of(const HeldCloud& cloud) {
  const auto* const large = std::get_if<std::unique_ptr<LargeCloud>>(&cloud);
  return large != nullptr ? large->get() : nullptr;
}

const PointCloud& facts_of(const HeldCloud& cloud) {
  const LargeCloud* const large = large_of(cloud);
  return large != nullptr ? large->facts() : std::get<PointCloud>(cloud);
}

PointColumns points_of(HeldCloud& cloud) {
  LargeCloud* const large = large_of(cloud);
  return large != nullptr ? large->points() : alidade::points_of(std::get<PointCloud>(cloud));
}

bool knows_point_count(const CloudInputs& files, bool partial, const StatedSize& stated) {
  return !partial && stated.uncounted_bytes == 0 &&
         std::ranges::none_of(files.inputs, &CloudInput::is_changed);
}

void check_room(const std::filesystem::path& folder, std::uint64_t bytes, Listener& listener) {
  std::error_code error;
  const std::uintmax_t room = std::filesystem::space(folder, error).available;
  if (error) throw system_error(folder.string(), "cannot use this folder for temporary files", error.value());
  const std::string needed = quantity(static_cast<double>(bytes), "B"),
                    there = quantity(static_cast<double>(room), "B");
  if (bytes > room)
    throw file_error(folder, "not enough room for temporary files", needed + ", or another folder",
                     there + " free");
  listener.note(
      fmt::format("up to {} of temporary files in {}, where {} are free", needed, folder.string(), there));
}

}  // namespace alidade::jobs
