// SPDX-License-Identifier: MIT
#include "cloud/join_records.h"

#include <tuple>
#include <utility>

namespace alidade {

bool JoinedRecords::Order::operator()(std::size_t a, std::size_t b) const {
  const auto key = [this](std::size_t place) {
    const VariableLengthRecord& record = (*records)[place];
    return std::tie(record.record_id, record.user_id, record.description, record.extended, record.data);
  };
  return key(a) < key(b);
}

void JoinedRecords::join(std::size_t first) {
  std::size_t kept = first;
  for (std::size_t i = first; i < records_.size(); ++i) {
    if (earlier_.contains(i)) continue;
    if (kept != i) records_[kept] = std::move(records_[i]);
    ++kept;
  }
  records_.resize(kept);
  for (std::size_t i = first; i < kept; ++i) earlier_.insert(i);
}

}  // namespace alidade
