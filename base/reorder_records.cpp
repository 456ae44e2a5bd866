// SPDX-License-Identifier: MIT
#include "base/reorder_records.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <memory>
#include <vector>

#include "base/parallel.h"

namespace alidade {
namespace {

constexpr std::size_t k_piece_bytes = std::size_t{1} << 20;
constexpr std::size_t k_numbers_at_once = std::size_t{1} << 16;
constexpr std::size_t k_most_parts = 128;  ///< files that are open at once

using Take = std::function<void(std::span<const std::byte>)>;

/// Records that fit into so many bytes, at least one.
std::size_t records_in(std::size_t bytes, std::size_t record_bytes) {
  return std::max<std::size_t>(bytes / record_bytes, 1);
}

/// Reorders records that all fit into memory.
void reorder_in_memory(const ScratchFile& records, std::size_t record_bytes,
                       std::span<const std::uint32_t> order, const Take& take) {
  std::vector<std::byte> all(static_cast<std::size_t>(records.size())), piece;
  records.read(0, all);
  const std::size_t step = records_in(k_piece_bytes, record_bytes);
  for (std::size_t first = 0; first < order.size(); first += step) {
    const auto some = order.subspan(first, std::min(step, order.size() - first));
    piece.resize(some.size() * record_bytes);
    for (std::size_t i = 0; i < some.size(); ++i)
      std::memcpy(piece.data() + i * record_bytes, all.data() + some[i] * record_bytes, record_bytes);
    take(piece);
  }
}

/// Records of one part of the new order, each after its number there.
class Part {
 public:
  /// `buffer_bytes`: written at once.
  Part(const std::filesystem::path& folder, std::size_t buffer_bytes)
      : file_(folder), buffer_bytes_(buffer_bytes) {}

  void add(std::uint32_t number, std::span<const std::byte> record) {
    const auto head = std::as_bytes(std::span(&number, 1));
    buffer_.insert(buffer_.end(), head.begin(), head.end());
    buffer_.insert(buffer_.end(), record.begin(), record.end());
    if (buffer_.size() >= buffer_bytes_) flush();
  }

  /// All of them in order. Requires that their numbers begin with `first` and have no gaps.
  std::vector<std::byte> ordered(std::uint32_t first, std::size_t record_bytes) {
    flush();
    const std::size_t entry_bytes = sizeof(std::uint32_t) + record_bytes;
    const auto count = static_cast<std::size_t>(file_.size() / entry_bytes);
    std::vector<std::byte> records(count * record_bytes);
    const std::size_t step = records_in(k_piece_bytes, entry_bytes);
    for (std::size_t begin = 0; begin < count; begin += step) {
      buffer_.resize(std::min(step, count - begin) * entry_bytes);
      file_.read(begin * entry_bytes, buffer_);
      for (const std::byte* entry = buffer_.data(); entry < buffer_.data() + buffer_.size();
           entry += entry_bytes) {
        std::uint32_t number;
        std::memcpy(&number, entry, sizeof number);
        std::memcpy(records.data() + (number - first) * record_bytes, entry + sizeof number, record_bytes);
      }
    }
    return records;
  }

 private:
  void flush() {
    file_.append(buffer_);
    buffer_.clear();
  }

  ScratchFile file_;
  const std::size_t buffer_bytes_;
  std::vector<std::byte> buffer_;
};

/// Consecutive parts of the new order.
struct PartsToFill {
  std::vector<std::unique_ptr<Part>>& parts;
  std::size_t part_size;
  std::size_t first;  ///< number in the new order with which they begin

  void add(std::uint32_t number, std::span<const std::byte> record) const {
    if (number >= first && (number - first) / part_size < parts.size())
      parts[(number - first) / part_size]->add(number, record);
  }
};

/// Adds the records to the parts they belong to. `memory`: bytes for the inverse of a part of the order.
void fill_parts(const PartsToFill& parts, const ScratchFile& records, std::size_t record_bytes,
                std::span<const std::uint32_t> order, std::size_t memory) {
  const std::size_t rows_at_once = std::max(k_numbers_at_once, memory / sizeof(std::uint32_t));
  const std::size_t step = records_in(k_piece_bytes, record_bytes);
  std::vector<std::uint32_t> numbers;  // of rows from `first` on in the new order
  std::vector<std::byte> piece;
  for (std::size_t first = 0; first < order.size(); first += rows_at_once) {
    numbers.resize(std::min(rows_at_once, order.size() - first));
    in_parallel(order.size(), k_numbers_at_once, [&](std::size_t i) {
      const std::size_t row = order[i];
      if (row >= first && row - first < numbers.size()) numbers[row - first] = static_cast<std::uint32_t>(i);
    });
    for (std::size_t begin = 0; begin < numbers.size(); begin += step) {
      const std::size_t count = std::min(step, numbers.size() - begin);
      piece.resize(count * record_bytes);
      records.read((first + begin) * record_bytes, piece);
      for (std::size_t i = 0; i < count; ++i)
        parts.add(numbers[begin + i], std::span(piece).subspan(i * record_bytes, record_bytes));
    }
  }
}

}  // namespace

void reorder_records(const ScratchFile& records, std::size_t record_bytes,
                     std::span<const std::uint32_t> order, const ScratchSpace& scratch, const Take& take) {
  assert(records.size() == order.size() * record_bytes);
  const auto memory = static_cast<std::size_t>(scratch.memory);
  const std::size_t part_size = records_in(memory / 2, record_bytes);
  if (order.size() <= part_size) return reorder_in_memory(records, record_bytes, order, take);
  const std::size_t part_count = (order.size() + part_size - 1) / part_size;
  for (std::size_t first = 0; first < part_count; first += k_most_parts) {
    std::vector<std::unique_ptr<Part>> parts(std::min(k_most_parts, part_count - first));
    for (auto& part : parts) part = std::make_unique<Part>(scratch.folder, memory / 4 / k_most_parts);
    const PartsToFill to_fill{parts, part_size, first * part_size};
    fill_parts(to_fill, records, record_bytes, order, memory / 4);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const std::vector<std::byte> part =
          parts[i]->ordered(static_cast<std::uint32_t>((first + i) * part_size), record_bytes);
      parts[i].reset();
      const std::size_t bytes = records_in(k_piece_bytes, record_bytes) * record_bytes;
      for (std::size_t begin = 0; begin < part.size(); begin += bytes)
        take(std::span(part).subspan(begin, std::min(bytes, part.size() - begin)));
    }
  }
}

}  // namespace alidade
