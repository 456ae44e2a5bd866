// SPDX-License-Identifier: MIT
#include "cloud/e57/e57_points.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "base/bytes.h"

namespace alidade {
namespace {

/// The `width` bits from bit `shift` (0 to 7) of the nine bytes at `at`.
std::uint64_t bits_at(const std::byte* at, unsigned shift, unsigned width) {
  std::uint64_t value = load<std::uint64_t>(at) >> shift;
  if (shift + width > 64) value |= load<std::uint8_t>(at + 8) * (std::uint64_t{1} << (64 - shift));
  return width == 64 ? value : value & ((std::uint64_t{1} << width) - 1);
}

constexpr std::size_t k_block = 4096;
constexpr unsigned k_data_packet = 1, k_empty_packet = 2;  // 0: index
constexpr std::size_t k_data_header = 6;

}  // namespace

void BitQueue::add(std::span<const std::byte> piece) {
  const std::size_t used = static_cast<std::size_t>(next_bit_ / 8);
  // The cost is linear, as the rest is moved only when at least as many bytes were used.
  if (used > 0 && used >= bytes_.size() - used) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(used));
    next_bit_ %= 8;
  }
  bytes_.insert(bytes_.end(), piece.begin(), piece.end());
}

bool BitQueue::restart() {
  if (width_ == 0) return true;
  // The padding of a byte looks like further numbers if these are narrow.
  const bool is_filling = width_ < 8 && bit_count() < 8;
  if (available(1) > 0 && !is_filling)
    return width_ >= 8 && bit_count() % static_cast<std::uint64_t>(width_) == 0;
  bytes_.clear();
  next_bit_ = 0;
  return true;
}

std::size_t BitQueue::available(std::size_t most) const {
  if (width_ == 0) return most;
  return static_cast<std::size_t>(
      std::min<std::uint64_t>(bit_count() / static_cast<std::uint64_t>(width_), most));
}

void BitQueue::take(std::span<std::uint64_t> numbers) {
  if (width_ == 0) {
    std::ranges::fill(numbers, 0);
    return;
  }
  const unsigned width = static_cast<unsigned>(width_);
  for (std::uint64_t& number : numbers) {
    const std::size_t byte = static_cast<std::size_t>(next_bit_ / 8);
    const unsigned shift = static_cast<unsigned>(next_bit_ % 8);
    if (bytes_.size() - byte >= 9) {
      number = bits_at(bytes_.data() + byte, shift, width);
    } else {
      std::array<std::byte, 9> last{};
      std::memcpy(last.data(), bytes_.data() + byte, bytes_.size() - byte);
      number = bits_at(last.data(), shift, width);
    }
    next_bit_ += width;
  }
}

E57Records::E57Records(E57Pages& pages, const E57Scan& scan, std::string where,
                       std::span<const std::size_t> wanted)
    : pages_(pages), scan_(scan), where_(std::move(where)), offset_(scan.first_packet) {
  for (const std::size_t field : wanted) streams_.push_back({field, BitQueue(scan.fields[field].bits())});
}

void E57Records::visit(const Visitor& visitor) {
  std::vector<std::vector<double>> columns(streams_.size(), std::vector<double>(k_block));
  std::vector<std::uint64_t> numbers(k_block);
  for (std::uint64_t done = 0; done < scan_.record_count;) {
    std::size_t count = static_cast<std::size_t>(std::min<std::uint64_t>(scan_.record_count - done, k_block));
    for (const Stream& stream : streams_) count = stream.queue.available(count);
    if (count == 0) {
      if (next_packet()) continue;
      fail("truncated section", fmt::format("{} records", scan_.record_count), std::to_string(done));
    }
    for (std::size_t i = 0; i < streams_.size(); ++i) {
      const std::span<std::uint64_t> taken = std::span(numbers).first(count);
      streams_[i].queue.take(taken);
      decode(streams_[i], taken, columns[i]);
    }
    visitor(columns, count);
    done += count;
  }
}

/// Reads the next packet; false at the end of the section.
bool E57Records::next_packet() {
  constexpr std::size_t k_smallest = 4;
  const std::uint64_t left = scan_.end - offset_;
  if (left == 0) return false;
  ++packet_;
  if (left < k_smallest) fail("the section ends inside a packet", "at least 4 bytes", std::to_string(left));
  const std::span<const std::byte> head = pages_.view(offset_, k_smallest);
  const unsigned kind = load<std::uint8_t>(head.data());
  const std::size_t length = load<std::uint16_t>(head.data() + 2) + std::size_t{1};
  if (kind > k_empty_packet) fail("unknown packet type", "0, 1 or 2", std::to_string(kind));
  if (length % 4 != 0) fail("invalid packet length", "a multiple of 4", std::to_string(length));
  if (length > left)
    fail("the packet exceeds its section", fmt::format("at most {} bytes", left), std::to_string(length));
  if (kind == k_data_packet) take_pieces(pages_.view(offset_, length));
  offset_ += length;
  return true;
}

void E57Records::take_pieces(std::span<const std::byte> packet) {
  if (packet.size() < k_data_header)
    fail("the packet is too short", fmt::format("at least {} bytes", k_data_header),
         std::to_string(packet.size()));
  const bool restarts = (load<std::uint8_t>(packet.data() + 1) & 1) != 0;
  const std::size_t count = load<std::uint16_t>(packet.data() + 4);
  if (count != scan_.fields.size()) {
    fail("wrong number of streams", std::to_string(scan_.fields.size()), std::to_string(count));
  }
  if (packet.size() < k_data_header + 2 * count) {
    fail("the packet is too short for its streams",
         fmt::format("at least {} bytes", k_data_header + 2 * count), std::to_string(packet.size()));
  }
  std::size_t begin = k_data_header + 2 * count;
  auto stream = streams_.begin();
  for (std::size_t field = 0; field < count; ++field) {
    const std::size_t length = load<std::uint16_t>(packet.data() + k_data_header + 2 * field);
    if (length > packet.size() - begin) {
      fail("the packet is too short for its stream of " + scan_.fields[field].name,
           fmt::format("at most {} bytes", packet.size() - begin), std::to_string(length));
    }
    if (stream != streams_.end() && stream->field == field) {
      if (restarts && !stream->queue.restart())
        fail("unexpected compressor restart inside the records of " + scan_.fields[field].name);
      stream->queue.add(packet.subspan(begin, length));
      ++stream;
    }
    begin += length;
  }
}

void E57Records::decode(const Stream& stream, std::span<const std::uint64_t> numbers,
                        std::span<double> values) const {
  const E57Field& field = scan_.fields[stream.field];
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (field.kind == E57FieldKind::float64) {
      values[i] = std::bit_cast<double>(numbers[i]);
    } else if (field.kind == E57FieldKind::float32) {
      values[i] = static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(numbers[i])));
    } else {
      // Unsigned, because codes above the maximum may exceed 64 bits.
      const auto stored = static_cast<std::int64_t>(static_cast<std::uint64_t>(field.minimum) + numbers[i]);
      values[i] = static_cast<double>(stored) * field.scale + field.offset;
    }
  }
}

void E57Records::fail(std::string problem, std::string expected, std::string found) const {
  pages_.fail(fmt::format("{}, packet {}", where_, packet_), std::move(problem), std::move(expected),
              std::move(found));
}

}  // namespace alidade
