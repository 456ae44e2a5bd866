// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/fingerprint.h"
#include "base/input_file.h"

// Resumable runs. A run is cut into parts of a fixed order, whose answers do not depend on each other. A file
// keeps the finished parts: a run that was interrupted or killed computes only the others, and ends with the
// bytes of an uninterrupted one. Little endian.
//
//   byte 0   8 B  "ALIDRUNS"             magic
//        8   4 B  0x01020304             byte order
//       12   4 B  1                      version of this format
//       16   8 B                         number of parts
//       24   8 B                         checksum of the head: of bytes 0 to `head`, this field taken as 0
//       32   8 B                         bytes of the fingerprint, which follows; both together are the head
//       40        fingerprint            base/fingerprint.h
//     head        records                each: 8 B number of the part, 8 B bytes of its answers, 8 B checksum
//                                        of these, 8 B checksum of the 24 B before, answers
//
// Records are only ever appended. A last one that is cut short is what a killed program leaves: the part is
// not finished.

namespace alidade {

class HeaderFields;

/// The name of a file in a checkpoint. Checkpoints go to other machines and people: of an absolute path they
/// keep the file's name and a checksum of the folder's, of a URL what public_name() keeps, of any other name
/// all.
std::string name_in_checkpoint(const std::filesystem::path& given);

/// How a kind of checkpoint begins: its magic, the byte order and the version of checkpoints, 8 bytes of the
/// kind, the checksum of the head, further fields of the kind, and the fingerprint of the computation. The
/// kinds are runs in parts (above) and images under way (renderer/checkpoint.h).
struct CheckpointForm {
  std::array<char, 8> magic;
  const char* name;               ///< in "is not NAME"
  std::size_t fixed_bytes;        ///< before the fingerprint
  std::size_t fingerprint_bytes;  ///< offset of the field with the length of the fingerprint
};

/// The head of a checkpoint; `fill` stores the fields of the kind.
std::vector<std::byte> checkpoint_head(const CheckpointForm& form, const Fingerprint& fingerprint,
                                       const std::function<void(std::byte*)>& fill);

/// Whether a file has the magic, of whatever version. Errors: those of InputFile.
bool begins_as(InputFile& file, const CheckpointForm& form);

/// Reads a head; `check` sees its fixed bytes before the fingerprint is read. Errors: not a checkpoint of the
/// kind; another byte order or version; damaged; those of `check`.
std::vector<std::byte> read_checkpoint_head(InputFile& file, const CheckpointForm& form,
                                            const std::function<void(const HeaderFields&)>& check);

/// The fingerprint in a head that was read from `file`.
Fingerprint fingerprint_of(const CheckpointForm& form, std::span<const std::byte> head,
                           const std::string& file);

struct PartsOptions {
  std::filesystem::path file{};
  double interval = 60.0;  ///< seconds after which finished parts are written, > 0
  bool resume = false;     ///< whether to resume from the file if it exists; else it is replaced
  /// Called when writing fails: the run continues, and the parts concerned count as not finished.
  std::function<void(const Error&)> failed{};
};

/// The finished parts of a run. To be used by one thread at a time.
class PartCheckpoint {
 public:
  /// Reads the file if it exists. `fingerprint`: all that the answers depend on. Errors: not a checkpoint of
  /// a run; another byte order, version or run, naming the first thing that differs; damaged; in use by
  /// another process. Cost: the file is read once. Memory: 64 B per part in it.
  PartCheckpoint(PartsOptions options, Fingerprint fingerprint);
  /// Writes finished parts that are not yet written.
  ~PartCheckpoint();
  PartCheckpoint(const PartCheckpoint&) = delete;
  PartCheckpoint& operator=(const PartCheckpoint&) = delete;

  std::string name() const { return options_.file.string(); }
  /// Whether the file exists.
  bool is_kept() const { return descriptor_.is_open(); }
  /// Parts that are finished, and all; 0 of 0 before start() of a new run.
  std::uint64_t finished() const { return entries_.size(); }
  std::uint64_t count() const { return count_; }
  /// Whether find() was called for a part that is not finished: then work has begun.
  bool has_begun() const { return has_begun_; }

  /// Sets the number of all parts; call it once, before the first part. Creates a missing file. Errors: the
  /// file has another number, or cannot be written.
  void start(std::uint64_t count);
  /// The answers of a part if it is finished. Errors: reading failed; the file was changed meanwhile.
  std::optional<std::vector<std::byte>> find(std::uint64_t part);
  /// Keeps the answers of a part. Written at once where they are large, or within PartsOptions::interval.
  /// Errors: writing failed, and the written part of a record cannot be removed.
  void add(std::uint64_t part, std::span<const std::byte> answers);
  /// Writes finished parts that are not yet written; those that cannot be written count as not finished.
  void flush() noexcept;
  /// Removes the file once it is not needed any more.
  void remove();

 private:
  struct Entry {
    std::uint64_t begin = 0, size = 0, checksum = 0;  ///< of the answers
  };

  void open();
  void read();
  void create();
  void write();

  PartsOptions options_;
  Fingerprint fingerprint_;
  FileDescriptor descriptor_;
  std::uint64_t count_ = 0, size_ = 0;      ///< size_: bytes of the file that are whole records
  std::map<std::uint64_t, Entry> entries_;  ///< by part
  std::vector<std::byte> pending_;          ///< records still to be written
  std::map<std::uint64_t, Entry> pending_entries_;
  bool has_begun_ = false;
  std::chrono::steady_clock::time_point written_;
};

/// Whether a file begins as these do, of whatever version. Errors: those of InputFile.
bool is_parts_file(const std::filesystem::path& file);

/// The answers of a part as bytes: numbers, one after another.
class PartWriter {
 public:
  template <class Value>
  void put(Value value) {
    put_all(std::span<const Value>(&value, 1));
  }

  /// A vector or span of numbers; how many there are is not put.
  template <class Values>
  void put_all(const Values& values) {
    static_assert(std::is_arithmetic_v<typename Values::value_type>);
    const auto bytes = std::as_bytes(std::span(values));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

/// Returns the values of a PartWriter in the order they were put.
class PartReader {
 public:
  /// `file` is what they come from, for messages. The bytes must outlive the object.
  PartReader(std::span<const std::byte> bytes, std::string file, std::uint64_t part)
      : bytes_(bytes), file_(std::move(file)), part_(part) {}

  /// Errors, here and below: there are not so many bytes left.
  template <class Value>
  Value take() {
    Value value{};
    std::span<Value> one(&value, 1);
    take_all(one);
    return value;
  }

  /// As many as the vector or span is long.
  template <class Values>
  void take_all(Values& values) {
    static_assert(std::is_arithmetic_v<typename Values::value_type>);
    const auto into = std::as_writable_bytes(std::span(values));
    require(bytes_.size() >= into.size());
    std::ranges::copy(bytes_.first(into.size()), into.begin());
    bytes_ = bytes_.subspan(into.size());
  }

  /// A number of values that follow, each of at least so many bytes: checked before memory is taken for them.
  std::size_t take_count(std::size_t least_bytes) {
    const auto count = take<std::uint64_t>();
    require(count <= bytes_.size() / least_bytes);
    return static_cast<std::size_t>(count);
  }

  /// Errors: bytes are left.
  void finish() const { require(bytes_.empty()); }

  /// Errors, unless `holds`: the part has invalid values.
  void require(bool holds) const {
    if (holds) return;
    throw Error(
        {.file = file_, .problem = "corrupt checkpoint: part " + std::to_string(part_) + " cannot be read"});
  }

 private:
  std::span<const std::byte> bytes_;
  std::string file_;
  std::uint64_t part_;
};

/// Goes through the parts of a run in their order: compute(part, writer) computes the answers of a part that
/// is not finished; use(part, reader) takes the answers, be they new or from the file. `parts` may be null:
/// then nothing is kept.
template <class Compute, class Use>
void run_parts(PartCheckpoint* parts, std::uint64_t count, const Compute& compute, const Use& use) {
  if (parts != nullptr) parts->start(count);
  for (std::uint64_t part = 0; part < count; ++part) {
    const std::optional<std::vector<std::byte>> found =
        parts != nullptr ? parts->find(part) : std::optional<std::vector<std::byte>>{};
    PartWriter writer;
    if (!found) {
      compute(part, writer);
      if (parts != nullptr) parts->add(part, writer.bytes());
    }
    PartReader reader(found ? *found : writer.bytes(), parts != nullptr ? parts->name() : "", part);
    use(part, reader);
    reader.finish();
  }
}

}  // namespace alidade
