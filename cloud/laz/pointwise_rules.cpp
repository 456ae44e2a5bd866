// SPDX-License-Identifier: MIT
#include "cloud/laz/pointwise_rules.h"

#include <cassert>
#include <cstring>

namespace alidade {

void Point10Models::start(const std::byte* first) {
  last_ = load<Point10>(first);
  changed_.reset();
  for (SymbolModelSet* models : {&bits_, &classifications_, &user_data_}) models->reset();
  for (IntegerCompressor* compressor : {&intensity_, &source_, &x_, &y_, &z_}) compressor->reset();
}

unsigned Point10Models::changes_to(const Point10& point) const {
  return (point.classification != last_.classification ? k_classification : 0) |
         (point.scan_angle != last_.scan_angle ? k_scan_angle : 0) |
         (point.user_data != last_.user_data ? k_user_data : 0) |
         (point.source != last_.source ? k_source : 0);
}

void Point10Version1::start(const std::byte* first) {
  Point10Models::start(first);
  x_steps_.fill(0);
  y_steps_.fill(0);
  oldest_ = 0;
  scan_angle_.reset();
}

unsigned Point10Version1::changes_to(const Point10& point) const {
  return Point10Models::changes_to(point) | (point.intensity != last_.intensity ? k_intensity : 0) |
         (point.bits != last_.bits ? k_bits : 0);
}

void Point10Version2::start(const std::byte* first) {
  Point10Models::start(first);
  // Not those of the first point: that is what all writers do.
  last_intensities_.fill(0);
  last_z_.fill(0);
  x_steps_.fill({});
  y_steps_.fill({});
  scan_angles_.reset();
}

unsigned Point10Version2::changes_to(const Point10& point) const {
  const unsigned kind = k_kinds[point.return_count()][point.return_number()];
  return Point10Models::changes_to(point) | (point.intensity != last_intensities_[kind] ? k_intensity : 0) |
         (point.bits != last_.bits ? k_bits : 0);
}

void GpsTimeVersion1::start(const std::byte* first) {
  time_ = load<std::int64_t>(first);
  difference_ = 0;
  extremes_ = 0;
  first_.reset();
  multiple_.reset();
  integers_.reset();
}

unsigned GpsTimeVersion1::multiple_of(std::int32_t change) const {
  const std::int64_t quotient = std::int64_t{change} / difference_;
  return static_cast<unsigned>(std::clamp<std::int64_t>(quotient, 0, k_largest_multiple));
}

void ExtraBytesVersion2::start(const std::byte* first) {
  std::memcpy(last_.data(), first, last_.size());
  differences_.reset();
}

BytesVersion1::BytesVersion1(std::size_t count, Written written)
    : written_(written), last_(count), bytes_(8, static_cast<int>(count)) {
  assert(written == Written::all || count == 6);
}

void BytesVersion1::start(const std::byte* first) {
  std::memcpy(last_.data(), first, last_.size());
  changed_.reset();
  bytes_.reset();
}

}  // namespace alidade
