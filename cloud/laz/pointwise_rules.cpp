// SPDX-License-Identifier: MIT
#include "cloud/laz/pointwise_rules.h"

namespace alidade {

void Point10Version2::start(const std::byte* first) {
  last_ = load<Point10>(first);
  // Not those of the first point: that is what all writers do.
  last_intensities_.fill(0);
  last_z_.fill(0);
  x_steps_.fill({});
  y_steps_.fill({});
  changed_.reset();
  for (SymbolModelSet* models : {&bits_, &classifications_, &user_data_, &scan_angles_}) models->reset();
  for (IntegerCompressor* compressor : {&intensity_, &source_, &x_, &y_, &z_}) compressor->reset();
}

unsigned Point10Version2::changes_to(const Point10& point) const {
  const unsigned kind = k_kinds[point.return_count()][point.return_number()];
  unsigned changed = 0;
  if (point.bits != last_.bits) changed |= k_bits;
  if (point.intensity != last_intensities_[kind]) changed |= k_intensity;
  if (point.classification != last_.classification) changed |= k_classification;
  if (point.scan_angle != last_.scan_angle) changed |= k_scan_angle;
  if (point.user_data != last_.user_data) changed |= k_user_data;
  if (point.source != last_.source) changed |= k_source;
  return changed;
}

}  // namespace alidade
