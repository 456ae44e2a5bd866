// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace alidade {

/// A value of a row, highest byte first; without bytes: NULL.
using CopyField = std::span<const std::byte>;

/// Takes what COPY ... TO STDOUT (FORMAT binary) sends, cut anywhere, and gives its rows. Only for values of
/// at most 8 bytes. Errors: it is not that, or another number of fields. Source: PostgreSQL 15 documentation,
/// COPY, "Binary Format".
class CopyDecoder {
 public:
  using TakeRow = std::function<void(std::span<const CopyField>)>;

  CopyDecoder(std::size_t fields, TakeRow take) : fields_(fields), take_(std::move(take)) {}

  void add(std::span<const std::byte> bytes);

  /// Errors: the end has not come.
  void finish() const;

 private:
  std::size_t take_head(std::span<const std::byte> bytes);
  std::size_t take_row(std::span<const std::byte> bytes);

  enum class Place { head, rows, end };

  std::vector<CopyField> fields_;
  TakeRow take_;
  Place place_ = Place::head;
  std::vector<std::byte> left_;  ///< of a row that has not come wholly
};

}  // namespace alidade
