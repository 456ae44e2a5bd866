// SPDX-License-Identifier: MIT
#include "base/checkpoint.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <utility>

#include "base/bytes.h"
#include "base/error.h"
#include "base/fingerprint.h"
#include "base/output_file.h"

namespace alidade {
namespace {

constexpr CheckpointForm k_runs = {.magic = {'A', 'L', 'I', 'D', 'R', 'U', 'N', 'S'},
                                   .name = "a visibility checkpoint",
                                   .fixed_bytes = 40,
                                   .fingerprint_bytes = 32};
constexpr std::uint32_t k_byte_order = 0x01020304, k_other_byte_order = 0x04030201, k_version = 1;
constexpr std::size_t k_checksum = 24, k_record_bytes = 32, k_summed_bytes = 24;
constexpr std::size_t k_most_pending = std::size_t{4} << 20;

std::uint64_t head_checksum(std::vector<std::byte> head) {
  store<std::uint64_t>(head.data() + k_checksum, 0);
  return checksum(head);
}

[[noreturn]] void fail_as_damaged(const std::string& file, std::uint64_t offset, std::uint64_t part,
                                  std::uint64_t expected, std::uint64_t found) {
  fail_at_byte(file, offset, fmt::format("corrupt checkpoint: wrong checksum of part {}", part),
               fmt::format("{:016x}", expected), fmt::format("{:016x}", found));
}

}  // namespace

std::string name_in_checkpoint(const std::filesystem::path& given) {
  const std::filesystem::path file = public_name(given.string());
  if (!file.is_absolute()) return file.string();
  const std::string folder = file.parent_path().string();
  return fmt::format("{} in folder {:016x}", file.filename().string(),
                     checksum(std::as_bytes(std::span(folder))));
}

std::vector<std::byte> checkpoint_head(const CheckpointForm& form, const Fingerprint& fingerprint,
                                       const std::function<void(std::byte*)>& fill) {
  std::vector<std::byte> bytes(form.fixed_bytes);
  append_fingerprint(fingerprint, bytes);
  store(bytes.data(), form.magic);
  store(bytes.data() + 8, k_byte_order);
  store(bytes.data() + 12, k_version);
  store(bytes.data() + form.fingerprint_bytes, static_cast<std::uint32_t>(bytes.size() - form.fixed_bytes));
  fill(bytes.data());
  store(bytes.data() + k_checksum, head_checksum(bytes));
  return bytes;
}

bool begins_as(InputFile& file, const CheckpointForm& form) {
  const auto start = file.view_up_to(0, form.magic.size());
  return start.size() == form.magic.size() &&
         std::memcmp(start.data(), form.magic.data(), form.magic.size()) == 0;
}

std::vector<std::byte> read_checkpoint_head(InputFile& file, const CheckpointForm& form,
                                            const std::function<void(const HeaderFields&)>& check) {
  if (!begins_as(file, form)) fail_at_byte(file.name(), 0, fmt::format("not {}", form.name));
  std::vector<std::byte> bytes(form.fixed_bytes);
  file.read_at(0, bytes);
  const std::string name = file.name();
  {
    const HeaderFields fixed(bytes, name);
    const auto order = fixed.get<std::uint32_t>(8);
    fixed.require(order != k_other_byte_order, 8, "wrong byte order", "little endian", "big endian");
    fixed.require(order == k_byte_order, 8, "invalid byte order mark", "01020304",
                  fmt::format("{:08x}", order));
    const auto version = fixed.get<std::uint32_t>(12);
    fixed.require(version == k_version, 12, "unsupported checkpoint version", std::to_string(k_version),
                  version);
    check(fixed);
    const std::uint64_t most = file.size() - form.fixed_bytes;
    const auto fingerprint = fixed.get<std::uint32_t>(form.fingerprint_bytes);
    fixed.require(fingerprint <= most, form.fingerprint_bytes,
                  "corrupt checkpoint: the fingerprint exceeds the file",
                  fmt::format("at most {} bytes", most), fingerprint);
    bytes.resize(form.fixed_bytes + fingerprint);
  }
  file.read_at(form.fixed_bytes, std::span(bytes).subspan(form.fixed_bytes));
  const HeaderFields whole(bytes, name);
  const auto said = whole.get<std::uint64_t>(k_checksum);
  const std::uint64_t sum = head_checksum(bytes);
  whole.require(said == sum, k_checksum, "corrupt checkpoint: wrong header checksum",
                fmt::format("{:016x}", said), fmt::format("{:016x}", sum));
  return bytes;
}

Fingerprint fingerprint_of(const CheckpointForm& form, std::span<const std::byte> head,
                           const std::string& file) {
  return read_fingerprint(head.subspan(form.fixed_bytes), form.fixed_bytes, file);
}

PartCheckpoint::PartCheckpoint(PartsOptions options, Fingerprint fingerprint)
    : options_(std::move(options)),
      fingerprint_(std::move(fingerprint)),
      written_(std::chrono::steady_clock::now()) {
  std::error_code error;
  if (!options_.resume || !std::filesystem::exists(options_.file, error)) return;
  open();
  read();
  // Cuts off the incomplete last record of a killed program.
  if (::ftruncate(descriptor_.number(), static_cast<::off_t>(size_)) != 0)
    throw system_error(name(), "cannot write the file");
}

PartCheckpoint::~PartCheckpoint() {
  flush();
}

void PartCheckpoint::flush() noexcept {
  if (!descriptor_.is_open()) return;
  try {
    write();
  } catch (const std::exception&) {
    // A noexcept function cannot report this; the records in the file stay.
    pending_.clear();
    pending_entries_.clear();
  }
}

void PartCheckpoint::open() {
  FileDescriptor descriptor(::open(options_.file.c_str(), O_RDWR | O_CLOEXEC));
  if (!descriptor.is_open()) throw system_error(name(), "cannot write the file");
  descriptor.lock_checkpoint(name());
  descriptor_ = std::move(descriptor);
}

void PartCheckpoint::read() {
  InputFile file(options_.file);
  const std::vector<std::byte> head = read_checkpoint_head(file, k_runs, [](const HeaderFields&) {});
  check_fingerprint(fingerprint_of(k_runs, head, file.name()), fingerprint_, file.name(),
                    {.of = "run", .same = "cloud and options"});
  count_ = load<std::uint64_t>(head.data() + 16);
  size_ = head.size();
  std::vector<std::byte> record(k_record_bytes), answers;
  while (file.size() - size_ >= k_record_bytes) {
    file.read_at(size_, record);
    const std::string file_name = file.name();
    const HeaderFields fields(record, file_name);
    const auto part = fields.get<std::uint64_t>(0), size = fields.get<std::uint64_t>(8),
               said = fields.get<std::uint64_t>(16), record_sum = fields.get<std::uint64_t>(k_summed_bytes);
    const std::uint64_t sum = checksum(std::span(record).first(k_summed_bytes));
    if (sum != record_sum) fail_as_damaged(file.name(), size_, part, record_sum, sum);
    if (part >= count_) {
      fail_at_byte(file.name(), size_, "corrupt checkpoint: invalid part number",
                   fmt::format("less than {}", count_), std::to_string(part));
    }
    const std::uint64_t begin = size_ + k_record_bytes;
    if (size > file.size() - begin) return;
    answers.resize(size);
    file.read_at(begin, answers);
    if (const std::uint64_t found = checksum(answers); found != said)
      fail_as_damaged(file.name(), begin, part, said, found);
    entries_[part] = {begin, size, said};
    size_ = begin + size;
  }
}

void PartCheckpoint::create() {
  const std::vector<std::byte> head =
      checkpoint_head(k_runs, fingerprint_, [this](std::byte* bytes) { store(bytes + 16, count_); });
  OutputFile file(options_.file, true);
  file.write(head);
  file.commit();
  size_ = head.size();
  open();
}

void PartCheckpoint::start(std::uint64_t count) {
  if (!descriptor_.is_open()) {
    count_ = count;
    return create();
  }
  if (count_ == count) return;
  fail_at_byte(name(), 16, "corrupt checkpoint: wrong number of parts", std::to_string(count),
               std::to_string(count_));
}

std::optional<std::vector<std::byte>> PartCheckpoint::find(std::uint64_t part) {
  const auto found = entries_.find(part);
  if (found == entries_.end()) {
    has_begun_ = true;
    return std::nullopt;
  }
  const Entry& entry = found->second;
  std::vector<std::byte> answers(entry.size);
  if (descriptor_.read_at(entry.begin, answers) < answers.size() && errno != 0)
    throw system_error(name(), "cannot read the file");
  if (const std::uint64_t sum = checksum(answers); sum != entry.checksum)
    fail_as_damaged(name(), entry.begin, part, entry.checksum, sum);
  return answers;
}

void PartCheckpoint::add(std::uint64_t part, std::span<const std::byte> answers) {
  assert(part < count_ && !entries_.contains(part));
  std::array<std::byte, k_record_bytes> record{};
  const Entry entry{size_ + pending_.size() + k_record_bytes, answers.size(), checksum(answers)};
  store(record.data(), part);
  store(record.data() + 8, entry.size);
  store(record.data() + 16, entry.checksum);
  store(record.data() + k_summed_bytes, checksum(std::span(record).first(k_summed_bytes)));
  pending_.insert(pending_.end(), record.begin(), record.end());
  pending_.insert(pending_.end(), answers.begin(), answers.end());
  pending_entries_[part] = entry;
  const std::chrono::duration<double> since = std::chrono::steady_clock::now() - written_;
  if (pending_.size() >= k_most_pending || since.count() >= options_.interval) write();
}

void PartCheckpoint::write() {
  if (!pending_.empty()) {
    try {
      write_fully(name(), descriptor_.number(), size_, pending_);
      if (::fdatasync(descriptor_.number()) != 0) throw system_error(name(), "cannot write the file");
      size_ += pending_.size();
      entries_.merge(pending_entries_);
    } catch (const Error& error) {
      // Records after an incomplete one could not be read.
      if (::ftruncate(descriptor_.number(), static_cast<::off_t>(size_)) != 0) throw;
      if (options_.failed) options_.failed(error);
    }
    pending_.clear();
    pending_entries_.clear();
  }
  written_ = std::chrono::steady_clock::now();
}

void PartCheckpoint::remove() {
  pending_.clear();
  pending_entries_.clear();
  descriptor_.close();
  std::error_code error;
  std::filesystem::remove(options_.file, error);
}

bool is_parts_file(const std::filesystem::path& path) {
  InputFile file(path);
  return begins_as(file, k_runs);
}

}  // namespace alidade
