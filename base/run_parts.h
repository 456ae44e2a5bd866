// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/checkpoint.h"

namespace alidade {

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

/// Gives them back in the order they were put.
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

  /// Errors: what was read makes no sense.
  void require(bool holds) const {
    if (holds) return;
    throw Error({.file = file_, .problem = "is damaged: part " + std::to_string(part_) + " cannot be read"});
  }

 private:
  std::span<const std::byte> bytes_;
  std::string file_;
  std::uint64_t part_;
};

/// Goes through the parts of a run in their order: compute(part, writer) answers what is not finished yet,
/// use(part, reader) takes the answers, be they new or from the file, so that both are taken alike. `parts`
/// may be null: then nothing is kept.
template <class Compute, class Use>
void run_parts(FinishedParts* parts, std::uint64_t count, const Compute& compute, const Use& use) {
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
