// SPDX-License-Identifier: MIT
#include "cloud/laz/pointwise_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>

#include "cloud/laz/arithmetic_encoder.h"
#include "cloud/laz/corrupt_chunk.h"

namespace alidade {
namespace {

constexpr std::size_t k_shortest_stream = 4;  // that of no points

}  // namespace

PointwiseDecoder::PointwiseDecoder(const LazLayout& layout)
    : record_size_(layout.record_size()), items_(make_pointwise_items(layout)) {}

void PointwiseDecoder::start(std::span<const std::byte> chunk) {
  const std::size_t shortest = record_size_ + k_shortest_stream;
  if (chunk.size() < shortest) {
    throw CorruptChunk(
        fmt::format("the chunk is too short; expected at least {} bytes for one point, found {}", shortest,
                    chunk.size()));
  }
  chunk_ = chunk;
  stream_ = ArithmeticDecoder(chunk.subspan(record_size_));
  point_ = 0;
}

void PointwiseDecoder::decode(std::span<std::byte> records) {
  assert(records.size() % record_size_ == 0);
  std::byte* record = records.data();
  std::byte* const end = record + records.size();
  if (point_ == 0 && record != end) {
    std::memcpy(record, chunk_.data(), record_size_);
    for (const PlacedItem& item : items_) item.rules->start(record + item.place);
    if (stream_.failed()) throw_corrupt();
    record += record_size_;
    ++point_;
  }
  for (; record != end; record += record_size_, ++point_) {
    for (const PlacedItem& item : items_) item.rules->decode(stream_, record + item.place);
    if (stream_.failed()) throw_corrupt();
  }
}

void PointwiseDecoder::throw_corrupt() const {
  const std::size_t size = chunk_.size();
  if (record_size_ + stream_.consumed() == size) {
    throw CorruptChunk(
        fmt::format("the points do not end where the chunk does; expected all within {} bytes, found more",
                    size),
        point_);
  }
  throw CorruptChunk("a point is damaged; expected values that encoders write, found others", point_);
}

PointwiseEncoder::PointwiseEncoder(const LazLayout& layout)
    : record_size_(layout.record_size()), items_(make_pointwise_items(layout)) {}

std::vector<std::byte> PointwiseEncoder::encode(std::span<const std::byte> records) {
  assert(!records.empty() && records.size() % record_size_ == 0);
  for (const PlacedItem& item : items_) item.rules->start(records.data() + item.place);
  ArithmeticEncoder encoder;
  for (std::size_t at = record_size_; at < records.size(); at += record_size_)
    for (const PlacedItem& item : items_) item.rules->encode(encoder, records.data() + at + item.place);
  const std::vector<std::byte> stream = encoder.finish();
  std::vector<std::byte> chunk(record_size_ + stream.size());
  std::copy_n(records.data(), record_size_, chunk.data());
  std::copy(stream.begin(), stream.end(), chunk.begin() + static_cast<std::ptrdiff_t>(record_size_));
  return chunk;
}

}  // namespace alidade
