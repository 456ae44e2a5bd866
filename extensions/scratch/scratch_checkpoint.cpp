// SPDX-License-Identifier: MIT
#include "extensions/scratch/scratch_checkpoint.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <charconv>
#include <string>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "base/error.h"
#include "base/output_file.h"

namespace alidade {
namespace {

// Behind the fingerprint follow the files: their names, and as values their bytes and checksums.
constexpr CheckpointForm k_form = {.magic = {'A', 'L', 'I', 'D', 'R', 'O', 'W', 'S'},
                                   .name = "a checkpoint of kept rows",
                                   .fixed_bytes = 56,
                                   .fingerprint_bytes = 32};
constexpr std::size_t k_rows = 16, k_entries = 40, k_made_folder = 48;
constexpr std::string_view k_manifest = "manifest", k_new_manifest = ".manifest.part-", k_prefix = "rows-",
                           k_positions = "rows-positions", k_attribute = "rows-attribute-",
                           k_nameless = ".alidade-";  ///< where the file system has no files without a name
constexpr std::size_t k_random_letters = 6;

bool is_number(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

/// A manifest that is not finished: "PROCESS-ATTEMPT" (temporary_beside()).
bool is_new_manifest(std::string_view name) {
  if (!name.starts_with(k_new_manifest)) return false;
  name.remove_prefix(k_new_manifest.size());
  const std::size_t dash = name.find('-');
  return dash != std::string_view::npos && is_number(name.substr(0, dash)) &&
         is_number(name.substr(dash + 1));
}

bool is_of_rows(std::string_view name) {
  if (name == k_positions) return true;
  if (name.starts_with(k_attribute)) return is_number(name.substr(k_attribute.size()));
  return name.starts_with(k_nameless) && name.size() == k_nameless.size() + k_random_letters;
}

/// No link, which might lead to a file of the user.
bool is_plain_file(const std::filesystem::directory_entry& entry) {
  std::error_code error;
  return std::filesystem::is_regular_file(entry.symlink_status(error));
}

/// The manifest's entry of a file: "BYTES CHECKSUM".
std::pair<std::uint64_t, std::uint64_t> stated_content(const FingerprintEntry& entry,
                                                       const std::string& file) {
  std::uint64_t bytes = 0, sum = 0;
  const char* const end = entry.value.data() + entry.value.size();
  const auto [blank, problem] = std::from_chars(entry.value.data(), end, bytes);
  if (problem == std::errc() && blank != end && *blank == ' ') {
    const auto [last, second_problem] = std::from_chars(blank + 1, end, sum, 16);
    if (second_problem == std::errc() && last == end) return {bytes, sum};
  }
  throw file_error(file, "corrupt checkpoint: invalid content of " + entry.name, "size and checksum",
                   entry.value);
}

constexpr const char* k_remedy = "--overwrite without --resume to start again";

}  // namespace

ScratchCheckpoint::ScratchCheckpoint(PartsOptions options, Fingerprint fingerprint,
                                     std::function<bool()> is_interrupted)
    : options_(std::move(options)),
      fingerprint_(std::move(fingerprint)),
      is_interrupted_(std::move(is_interrupted)),
      kept_(std::chrono::steady_clock::now()) {
  const std::string name = folder().string();
  std::error_code error;
  made_folder_ = std::filesystem::create_directory(folder(), error);
  if (error) throw system_error(name, "cannot create the folder", error.value());
  lock_ = FileDescriptor(name, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  lock_.lock_checkpoint(name);
  if (!is_scratch_checkpoint(folder()))
    throw file_error(name, "not a checkpoint of kept rows",
                     "a checkpoint, or the name of a folder that does not exist");
  resumes_ = options_.resume && std::filesystem::exists(folder() / k_manifest, error);
  try {
    resumes_ ? read() : begin();
  } catch (const Error& problem) {
    Error::Parts parts = problem.parts();
    if (parts.problem.find("corrupt") != std::string::npos)
      parts.expected += (parts.expected.empty() ? "" : ", or ") + std::string(k_remedy);
    throw Error(std::move(parts));
  }
}

void ScratchCheckpoint::begin() {
  try {
    // From the manifest that is replaced; if that is damaged, the folder counts as the user's.
    InputFile file(folder() / k_manifest);
    made_folder_ |=
        load<std::uint64_t>(read_checkpoint_head(file, k_form, [](const HeaderFields&) {}).data() +
                            k_made_folder) != 0;
  } catch (const Error&) {
  }
  try {
    if (!remove_rows()) write(0, {});
  } catch (const Error&) {
    remove();
    throw;
  }
}

/// Returns whether the manifest could be written, which then states 0 rows. That comes first: a kill
/// meanwhile leaves a checkpoint without rows, and neither a manifest of rows that are gone nor rows without
/// a manifest, which later runs would take for files of the user.
bool ScratchCheckpoint::remove_rows() {
  bool is_written = true;
  try {
    write(0, {});
  } catch (const Error&) {
    is_written = false;  // the rows fill the disk
  }
  std::error_code error;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder(), error)) {
    if (is_of_rows(entry.path().filename().string()) && is_plain_file(entry)) files.push_back(entry.path());
  }
  for (const std::filesystem::path& file : files) std::filesystem::remove(file, error);
  return is_written;
}

void ScratchCheckpoint::read() {
  InputFile file(folder() / k_manifest);
  const std::vector<std::byte> head = read_checkpoint_head(file, k_form, [](const HeaderFields&) {});
  Fingerprint entries = fingerprint_of(k_form, head, file.name());
  const auto count = static_cast<std::size_t>(
      std::min<std::uint64_t>(load<std::uint64_t>(head.data() + k_entries), entries.size()));
  const auto first_file = entries.begin() + static_cast<std::ptrdiff_t>(count);
  check_fingerprint(Fingerprint(entries.begin(), first_file), fingerprint_, folder().string(),
                    {.of = "run", .same = "cloud and options"});
  for (auto entry = first_file; entry != entries.end(); ++entry)
    std::tie(kept_files_[entry->name].bytes, kept_files_[entry->name].checksum) =
        stated_content(*entry, file.name());
  rows_ = load<std::uint64_t>(head.data() + k_rows);
  made_folder_ = load<std::uint64_t>(head.data() + k_made_folder) != 0;
}

KeptFile ScratchCheckpoint::file(const std::string& name) {
  const std::filesystem::path path = folder() / (std::string(k_prefix) + name);
  const auto kept = kept_files_.find(name);
  if (kept == kept_files_.end()) return {path, 0};
  const Content& content = kept->second;
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size < content.bytes)
    fail_as_corrupt(fmt::format("truncated file {}", path.filename().string()),
                    fmt::format("at least {} bytes", content.bytes),
                    error ? error.message() : std::to_string(size));
  KeptFile file(path, content.bytes);
  if (const std::uint64_t sum = file.checksum(is_interrupted_); sum != content.checksum)
    fail_as_corrupt(fmt::format("wrong checksum of {}", path.filename().string()),
                    fmt::format("{:016x}", content.checksum), fmt::format("{:016x}", sum));
  return file;
}

void ScratchCheckpoint::fail_as_corrupt(const std::string& problem, const std::string& expected,
                                        const std::string& found) {
  is_corrupt_ = true;
  throw file_error(folder().string(), "corrupt checkpoint: " + problem,
                   fmt::format("{}, or {}", expected, k_remedy), found);
}

bool ScratchCheckpoint::is_due() const {
  const std::chrono::duration<double> since = std::chrono::steady_clock::now() - kept_;
  return since.count() >= options_.interval;
}

void ScratchCheckpoint::keep(std::uint64_t rows, std::span<const Kept> files) {
  if (is_corrupt_) return;
  try {
    for (const Kept& kept : files) {
      // Partly written rows on a full disk would take the room of the manifest.
      kept.file->cut(kept.bytes);
      kept.file->sync();
    }
    if (::fsync(lock_.number()) != 0) throw system_error(folder().string(), "cannot write the folder");
    write(rows, files);
    rows_ = rows;
  } catch (const Error& error) {
    if (options_.failed) options_.failed(error);
  }
  kept_ = std::chrono::steady_clock::now();
}

void ScratchCheckpoint::write(std::uint64_t rows, std::span<const Kept> files) {
  Fingerprint entries = fingerprint_;
  for (const Kept& kept : files)
    entries.push_back({kept.name, fmt::format("{} {:016x}", kept.bytes, kept.file->checksum())});
  OutputFile manifest(folder() / k_manifest, true);
  manifest.write(checkpoint_head(k_form, entries, [&](std::byte* bytes) {
    store(bytes + k_rows, rows);
    store(bytes + k_entries, std::uint64_t{fingerprint_.size()});
    store(bytes + k_made_folder, std::uint64_t{made_folder_});
  }));
  manifest.commit();
}

void ScratchCheckpoint::remove() {
  remove_rows();
  std::error_code error;
  std::filesystem::remove(folder() / k_manifest, error);
  // Removes no link, and no folder with files in it.
  if (made_folder_) ::rmdir(folder().c_str());
}

bool is_scratch_checkpoint(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::directory_iterator entries(folder, error);
  if (error) return false;
  bool has_manifest = false, has_rows = false;
  for (const auto& entry : entries) {
    const std::string name = entry.path().filename().string();
    const bool is_manifest = name == k_manifest, is_rows = is_of_rows(name);
    if (!(is_manifest || is_rows || is_new_manifest(name)) || !is_plain_file(entry)) return false;
    has_manifest |= is_manifest;
    has_rows |= is_rows;
  }
  if (!has_manifest) return !has_rows;
  InputFile manifest(folder / k_manifest);
  return begins_as(manifest, k_form);
}

}  // namespace alidade
