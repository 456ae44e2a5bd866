// SPDX-License-Identifier: MIT
#include "base/scratch_checkpoint.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <system_error>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "base/error.h"
#include "base/output_file.h"

namespace alidade {
namespace {

// Behind the fingerprint follow the files: their names, and as values their bytes.
constexpr CheckpointForm k_form = {.magic = {'A', 'L', 'I', 'D', 'R', 'O', 'W', 'S'},
                                   .name = "a checkpoint of kept rows",
                                   .fixed_bytes = 48,
                                   .fingerprint_bytes = 32};
constexpr std::size_t k_rows = 16, k_entries = 40;
constexpr const char* k_manifest = "manifest";
/// Names of scratch files here begin with it, so that no other file is ever removed.
constexpr std::string_view k_prefix = "rows-";

bool is_ours(const std::string& name) {
  return name == k_manifest || name.starts_with(k_prefix) || name.starts_with(".manifest.part-");
}

std::uint64_t number_of_bytes(const FingerprintEntry& entry, const std::string& file) {
  std::uint64_t bytes = 0;
  const char* const end = entry.value.data() + entry.value.size();
  const auto [last, problem] = std::from_chars(entry.value.data(), end, bytes);
  if (problem != std::errc() || last != end)
    throw file_error(file, "corrupt checkpoint: invalid size of " + entry.name, "a number", entry.value);
  return bytes;
}

/// The manifest goes first: without it the others count for nothing.
void remove_files(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::remove(folder / k_manifest, error);
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (is_ours(entry.path().filename().string())) files.push_back(entry.path());
  }
  for (const std::filesystem::path& file : files) std::filesystem::remove(file, error);
}

}  // namespace

ScratchCheckpoint::ScratchCheckpoint(PartsOptions options, Fingerprint fingerprint)
    : options_(std::move(options)),
      fingerprint_(std::move(fingerprint)),
      kept_(std::chrono::steady_clock::now()) {
  const std::string name = folder().string();
  std::error_code error;
  std::filesystem::create_directory(folder(), error);
  if (error) throw system_error(name, "cannot create the folder", error.value());
  if (!is_scratch_checkpoint(folder()))
    throw file_error(name, "not a checkpoint of kept rows",
                     "a checkpoint, or the name of a folder that does not exist");
  lock_ = FileDescriptor(name, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  // Held until it is closed: two runs that append to the same files would damage them.
  if (::flock(lock_.number(), LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) throw file_error(name, "another run is using this checkpoint");
    throw system_error(name, "cannot lock the folder");
  }
  if (options_.resume && std::filesystem::exists(folder() / k_manifest, error)) {
    read();
  } else {
    begin();
  }
}

void ScratchCheckpoint::begin() {
  remove_files(folder());
  try {
    write(0, {});
  } catch (const Error&) {
    remove();
    throw;
  }
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
    bytes_[entry->name] = number_of_bytes(*entry, file.name());
  rows_ = load<std::uint64_t>(head.data() + k_rows);
}

ScratchFile ScratchCheckpoint::file(const std::string& name) const {
  const auto kept = bytes_.find(name);
  return {folder() / (std::string(k_prefix) + name), kept == bytes_.end() ? 0 : kept->second};
}

bool ScratchCheckpoint::is_due() const {
  const std::chrono::duration<double> since = std::chrono::steady_clock::now() - kept_;
  return since.count() >= options_.interval;
}

void ScratchCheckpoint::keep(std::uint64_t rows, std::span<const Kept> files) {
  try {
    for (const Kept& kept : files) kept.file->sync();
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
  for (const Kept& kept : files) entries.push_back({kept.name, std::to_string(kept.bytes)});
  OutputFile manifest(folder() / k_manifest, true);
  manifest.write(checkpoint_head(k_form, entries, [&](std::byte* bytes) {
    store(bytes + k_rows, rows);
    store(bytes + k_entries, std::uint64_t{fingerprint_.size()});
  }));
  manifest.commit();
}

void ScratchCheckpoint::remove() {
  remove_files(folder());
  std::error_code error;
  std::filesystem::remove(folder(), error);
}

bool is_scratch_checkpoint(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::directory_iterator entries(folder, error);
  if (error) return false;
  return std::all_of(begin(entries), end(entries),
                     [](const auto& entry) { return is_ours(entry.path().filename().string()); });
}

}  // namespace alidade
