// SPDX-License-Identifier: MIT
#include "database/server/copy_decoder.h"

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "base/error.h"
#include "cloud/point_table.h"

namespace alidade {
namespace {

constexpr std::string_view k_signature{"PGCOPY\n\377\r\n\0", 11};
constexpr std::size_t k_head = k_signature.size() + 2 * sizeof(std::int32_t);
constexpr std::int32_t k_longest = 8;

[[noreturn]] void refuse(std::string expected, std::string found) {
  throw Error({.problem = "the server sends rows that cannot be read",
               .expected = std::move(expected),
               .found = std::move(found)});
}

}  // namespace

/// How many bytes the head has; 0 if it is not there wholly.
std::size_t CopyDecoder::take_head(std::span<const std::byte> bytes) {
  if (bytes.size() < k_head) return 0;
  if (std::memcmp(bytes.data(), k_signature.data(), k_signature.size()) != 0)
    refuse("rows of COPY in binary", "another beginning");
  const auto flags = load<std::int32_t>(bytes.data() + k_signature.size(), std::endian::big);
  const auto more = load<std::int32_t>(bytes.data() + k_signature.size() + sizeof flags, std::endian::big);
  if (flags != 0 || more != 0) refuse("a head without flags", "one with some");
  place_ = Place::rows;
  return k_head;
}

/// How many bytes the next row has, which is handed over; 0 if it is not there wholly.
std::size_t CopyDecoder::take_row(std::span<const std::byte> bytes) {
  std::size_t at = 0;
  const auto has = [&](std::size_t count) { return bytes.size() - at >= count; };
  if (!has(sizeof(std::int16_t))) return 0;
  const auto count = load<std::int16_t>(bytes.data(), std::endian::big);
  at += sizeof count;
  if (count == -1) {
    place_ = Place::end;
    return at;
  }
  if (count < 0 || static_cast<std::size_t>(count) != fields_.size())
    refuse(std::to_string(fields_.size()) + " values in a row", std::to_string(count));
  for (CopyField& field : fields_) {
    if (!has(sizeof(std::int32_t))) return 0;
    const auto length = load<std::int32_t>(bytes.data() + at, std::endian::big);
    at += sizeof length;
    if (length < -1 || length > k_longest)
      refuse("values of at most 8 bytes", std::to_string(length) + " bytes");
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
    if (place_ == Place::end) refuse("nothing behind the last row", std::to_string(bytes.size()) + " bytes");
    const std::size_t taken = place_ == Place::head ? take_head(bytes) : take_row(bytes);
    if (taken == 0) break;
    bytes = bytes.subspan(taken);
  }
  // The rest may lie in what it replaces.
  left_ = std::vector<std::byte>(bytes.begin(), bytes.end());
}

void CopyDecoder::finish() const {
  if (place_ != Place::end) refuse("an end behind the last row", "none");
}

}  // namespace alidade
