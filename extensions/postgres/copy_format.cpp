// SPDX-License-Identifier: MIT
#include "extensions/postgres/copy_format.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <string>
#include <string_view>

#include "base/bytes.h"
#include "base/error.h"
#include "cloud/point_table.h"
#include "database/stored_column.h"

namespace alidade::database {
namespace {

constexpr std::string_view k_signature{"PGCOPY\n\377\r\n\0", 11};
constexpr std::size_t k_head = k_signature.size() + 2 * sizeof(std::int32_t);
constexpr std::int32_t k_longest = 8;

[[noreturn]] void reject_rows(std::string expected, std::string found) {
  throw input_error("the server sent invalid rows", std::move(expected), std::move(found));
}

/// Appends a number, highest byte first.
template <class Number>
void append_number(Number number, std::vector<std::byte>& bytes) {
  const std::size_t at = bytes.size();
  bytes.resize(at + sizeof number);
  store(bytes.data() + at, number);
  std::ranges::reverse(std::span(bytes).subspan(at));
}

/// Appends a field: its length and its bytes.
template <class Number>
void append_field(Number number, std::vector<std::byte>& bytes) {
  append_number(static_cast<std::int32_t>(sizeof number), bytes);
  append_number(number, bytes);
}

/// Appends a field of the type numeric: digits to the base of 10,000 without zeros at the end, the power of
/// the first one, the sign, the number of decimals.
void append_numeric(std::uint64_t number, std::vector<std::byte>& bytes) {
  constexpr std::uint64_t k_base = 10000;
  std::vector<std::int16_t> digits;  // lowest first
  for (; number > 0; number /= k_base) digits.push_back(static_cast<std::int16_t>(number % k_base));
  const auto weight = static_cast<std::int16_t>(digits.empty() ? 0 : digits.size() - 1);
  digits.erase(digits.begin(), std::ranges::find_if(digits, [](std::int16_t digit) { return digit != 0; }));
  append_number(static_cast<std::int32_t>(sizeof(std::int16_t) * (4 + digits.size())), bytes);
  append_number(static_cast<std::int16_t>(digits.size()), bytes);
  append_number(weight, bytes);
  append_number(std::int16_t{0}, bytes);
  append_number(std::int16_t{0}, bytes);
  for (auto digit = digits.rbegin(); digit != digits.rend(); ++digit) append_number(*digit, bytes);
}

void append_whole(ServerType type, std::int64_t whole, std::vector<std::byte>& bytes) {
  switch (type) {
    case ServerType::smallint:
      return append_field(static_cast<std::int16_t>(whole), bytes);
    case ServerType::integer:
      return append_field(static_cast<std::int32_t>(whole), bytes);
    case ServerType::numeric:
      return append_numeric(static_cast<std::uint64_t>(whole), bytes);
    default:
      return append_field(whole, bytes);
  }
}

void append_value(ServerType type, const ColumnValue& value, std::vector<std::byte>& bytes) {
  if (const auto* const whole = std::get_if<std::int64_t>(&value)) {
    append_whole(type, *whole, bytes);
  } else if (const auto* const large = std::get_if<std::uint64_t>(&value)) {
    append_numeric(*large, bytes);
  } else if (const auto* const number = std::get_if<double>(&value)) {
    if (type == ServerType::real)
      append_field(static_cast<float>(*number), bytes);
    else
      append_field(*number, bytes);
  } else if (const auto* const text = std::get_if<std::span<const std::byte>>(&value)) {
    append_number(static_cast<std::int32_t>(text->size()), bytes);
    bytes.insert(bytes.end(), text->begin(), text->end());
  } else {
    append_number(std::int32_t{-1}, bytes);  // NULL
  }
}

}  // namespace

/// Checks the header and returns its number of bytes; 0 if it is incomplete.
std::size_t CopyDecoder::take_head(std::span<const std::byte> bytes) {
  if (bytes.size() < k_head) return 0;
  if (std::memcmp(bytes.data(), k_signature.data(), k_signature.size()) != 0)
    reject_rows("rows in the binary format of COPY", "");
  const auto flags = load<std::int32_t>(bytes.data() + k_signature.size(), std::endian::big);
  const auto more = load<std::int32_t>(bytes.data() + k_signature.size() + sizeof flags, std::endian::big);
  if (flags != 0 || more != 0) reject_rows("a header without flags", "");
  part_ = Part::rows;
  return k_head;
}

/// Passes the next row on and returns its number of bytes; 0 if the row is not complete.
std::size_t CopyDecoder::take_row(std::span<const std::byte> bytes) {
  std::size_t at = 0;
  const auto has = [&](std::size_t count) { return bytes.size() - at >= count; };
  if (!has(sizeof(std::int16_t))) return 0;
  const auto count = load<std::int16_t>(bytes.data(), std::endian::big);
  at += sizeof count;
  if (count == -1) {
    part_ = Part::end;
    return at;
  }
  if (count < 0 || static_cast<std::size_t>(count) != fields_.size())
    reject_rows(std::to_string(fields_.size()) + " values in a row", std::to_string(count));
  for (CopyField& field : fields_) {
    if (!has(sizeof(std::int32_t))) return 0;
    const auto length = load<std::int32_t>(bytes.data() + at, std::endian::big);
    at += sizeof length;
    if (length < -1 || length > k_longest)
      reject_rows("values of at most 8 bytes", std::to_string(length) + " bytes");
    const auto size = static_cast<std::size_t>(length < 0 ? 0 : length);
    if (!has(size)) return 0;
    field = bytes.subspan(at, size);
    at += size;
  }
  take_(fields_);
  return at;
}

void CopyDecoder::add(std::span<const std::byte> bytes) {
  const bool has_left = !left_.empty();
  if (has_left) {
    left_.insert(left_.end(), bytes.begin(), bytes.end());
    bytes = left_;
  }
  while (!bytes.empty()) {
    if (part_ == Part::end)
      reject_rows("no data after the last row", std::to_string(bytes.size()) + " bytes");
    const std::size_t taken = part_ == Part::head ? take_head(bytes) : take_row(bytes);
    if (taken == 0) break;
    bytes = bytes.subspan(taken);
  }
  // `bytes` may be a part of left_.
  left_ = std::vector<std::byte>(bytes.begin(), bytes.end());
}

void CopyDecoder::finish() const {
  if (part_ != Part::end) reject_rows("an end marker", "");
}

CopyRows::CopyRows(std::vector<StoredColumn> columns, const Lattice& lattice)
    : columns_(std::move(columns)), lattice_(lattice) {
  std::ranges::transform(columns_, std::back_inserter(types_), server_type);
}

std::vector<std::byte> CopyRows::head() {
  std::vector<std::byte> bytes;
  for (const char character : k_signature) bytes.push_back(static_cast<std::byte>(character));
  append_number(std::int32_t{0}, bytes);  // flags
  append_number(std::int32_t{0}, bytes);  // length of the header extension
  return bytes;
}

std::vector<std::byte> CopyRows::tail() {
  std::vector<std::byte> bytes;
  append_number(std::int16_t{-1}, bytes);
  return bytes;
}

void CopyRows::append(const EncodedChunks& points, std::size_t i, std::vector<std::byte>& bytes) const {
  constexpr std::size_t k_axes = 3;
  append_number(static_cast<std::int16_t>(columns_.size() + k_axes), bytes);
  const glm::dvec3 position = to_world(lattice_, points.positions[i]);
  for (std::size_t number = 0; number < columns_.size(); ++number) {
    const StoredColumn& column = columns_[number];
    const std::byte* const values = points.blobs[static_cast<std::size_t>(column.blob)].data();
    append_value(types_[number],
                 stored_value(column, values + i * static_cast<std::size_t>(column.size) + column.byte),
                 bytes);
    if (number > 0) continue;
    for (int axis = 0; axis < 3; ++axis) append_field(position[axis], bytes);
  }
}

Bounds CopyRows::copy(
    OrderedCloud& cloud, std::uint64_t count,
    const std::function<void(std::span<const std::byte> bytes, std::size_t points)>& write) const {
  constexpr std::uint32_t k_rows_at_once = 8192;
  const ChunkEncoding encoding = cloud.encoding(k_rows_at_once);
  Bounds box;
  write(head(), 0);
  std::vector<std::byte> bytes;
  while (count > 0) {
    const EncodedChunks some =
        encode(encoding, cloud.points.next(std::min<std::size_t>(k_rows_at_once, count)));
    bytes.clear();
    for (std::size_t i = 0; i < some.positions.size(); ++i) append(some, i, bytes);
    write(bytes, some.positions.size());
    for (const Bounds& part : some.boxes) box.grow(part);
    count -= some.positions.size();
  }
  write(tail(), 0);
  return box;
}

}  // namespace alidade::database
