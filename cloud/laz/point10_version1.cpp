// SPDX-License-Identifier: MIT
#include "cloud/laz/point10_version1.h"

namespace alidade {

void Point10Version1::start(const std::byte* first) {
  last_ = load<Point10>(first);
  x_steps_.fill(0);
  y_steps_.fill(0);
  oldest_ = 0;
  changed_.reset();
  for (SymbolModelSet* models : {&bits_, &classifications_, &user_data_}) models->reset();
  for (IntegerCompressor* compressor : {&scan_angle_, &intensity_, &source_, &x_, &y_, &z_})
    compressor->reset();
}

unsigned Point10Version1::changes_to(const Point10& point) const {
  unsigned changed = 0;
  if (point.intensity != last_.intensity) changed |= k_intensity;
  if (point.bits != last_.bits) changed |= k_bits;
  if (point.classification != last_.classification) changed |= k_classification;
  if (point.scan_angle != last_.scan_angle) changed |= k_scan_angle;
  if (point.user_data != last_.user_data) changed |= k_user_data;
  if (point.source != last_.source) changed |= k_source;
  return changed;
}

}  // namespace alidade
