// SPDX-License-Identifier: MIT
#include "jobs/plan.h"

#include <fmt/format.h>
#include <unistd.h>
#include <cstdint>
#include <optional>
#include <system_error>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/input_file.h"
#include "base/shown_text.h"
#include "cloud/cloud_reader.h"
#include "jobs/outputs.h"
#include "octree/index_file/index_file.h"
#include "octree/index_file/index_header.h"

namespace alidade::jobs {
namespace {

std::string bytes_text(double bytes) {
  return quantity(bytes, "B");
}

/// ", 38 MB" for a file here, else nothing.
std::string size_of(const std::filesystem::path& file) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  return error ? "" : bytes_text(static_cast<double>(size));
}

std::string line(const char* what, const std::filesystem::path& file, const std::string& more) {
  return fmt::format("{:<7} {}{}{}\n", what, line_text(public_name(file.string())), more.empty() ? "" : "  ",
                     more);
}

/// Errors: the file is missing or may not be read. Patterns, and names of servers and of GDAL's data sets,
/// are left to those who open them.
void check_readable(const std::filesystem::path& file) {
  const std::string name = file.string();
  if (is_remote_name(name) || name.find_first_of("*?[:") != std::string::npos) return;
  if (::access(name.c_str(), R_OK) != 0) throw system_error(name, "cannot open the file");
}

}  // namespace

void check_outputs(const PlannedWork& work, bool overwrite) {
  std::vector<std::filesystem::path> inputs = work.clouds.names();
  inputs.insert(inputs.end(), work.reads.begin(), work.reads.end());
  check_outputs(work.writes, overwrite, inputs);
}

std::optional<Organisation> stored_organisation(const CloudInputs& clouds) {
  const CloudInput* const index = clouds.only(k_index_format);
  if (index == nullptr || index->changes_heights()) return std::nullopt;
  return IndexFile(index->file()).header().tree.organisation;
}

std::string text_of(const PlannedWork& work) {
  const Damage damage = work.partial ? Damage::read_over : Damage::reject;
  std::string text;
  std::uint64_t points = 0;
  bool are_all_known = true;
  for (const CloudInput& input : work.clouds.inputs) {
    const auto count = open_stored_cloud(input, damage)->facts().point_count;
    const std::string size = size_of(input.name);
    text += line("reads", input.name,
                 (count ? fmt::format("{} points", *count) : "points not counted yet") +
                     (size.empty() ? "" : ", ") + size);
    points += count.value_or(0);
    are_all_known = are_all_known && count;
  }
  for (const std::filesystem::path& file : work.reads) {
    if (file.empty()) continue;
    if (file == "-") {
      text += line("reads", "standard input", "");
      continue;
    }
    check_readable(file);
    text += line("reads", file, size_of(file));
  }
  for (const std::filesystem::path& file : work.writes) {
    std::error_code error;
    if (!file.empty())
      text += line("writes", file, std::filesystem::is_regular_file(file, error) ? "an existing file" : "");
  }
  if (work.bytes_per_point > 0.0 && are_all_known) {
    const std::optional<std::uint64_t> free = available_memory();
    text += fmt::format("{:<7} about {} of memory{}\n", "needs",
                        bytes_text(work.bytes_beside + work.bytes_per_point * static_cast<double>(points)),
                        free ? fmt::format("; {} are free", bytes_text(static_cast<double>(*free))) : "");
  }
  return text.empty() ? "reads and writes no files\n" : text;
}

}  // namespace alidade::jobs
