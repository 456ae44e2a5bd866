// SPDX-License-Identifier: MIT
#include "base/fingerprint.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstring>
#include <utility>

#include "base/bytes.h"
#include "base/error.h"
#include "base/words.h"

// The library's code is compiled in, so that programs need not link xxHash.
#define XXH_INLINE_ALL
#include <xxhash.h>

namespace alidade {

std::uint64_t checksum(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

void append_checksums(std::initializer_list<std::span<const std::byte>> arrays,
                      std::vector<std::uint64_t>& sums) {
  for (const std::span<const std::byte> array : arrays)
    sums.push_back(array.data() == nullptr ? 0 : checksum(array));
}

void ChecksumBlocks::put(std::span<const std::byte> block) {
  sums_.push_back(checksum(block));
  put_(block);
}

void ChecksumBlocks::add(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const std::span<const std::byte> part =
        bytes.first(std::min(bytes.size(), k_checksum_block - block_.size()));
    bytes = bytes.subspan(part.size());
    if (part.size() == k_checksum_block) {
      put(part);
      continue;
    }
    block_.insert(block_.end(), part.begin(), part.end());
    if (block_.size() == k_checksum_block) end();
  }
}

void ChecksumBlocks::end() {
  if (!block_.empty()) put(block_);
  block_.clear();
}

namespace {

constexpr std::size_t k_lengths = 8;

/// Excerpts of two different values for a message: of long ones, from the first word that differs.
std::pair<std::string, std::string> differing_parts(const std::string& a, const std::string& b) {
  constexpr std::size_t k_longest = 60, k_part = 40, k_word = 20;
  if (a.size() <= k_longest && b.size() <= k_longest) return {a, b};
  const auto difference = static_cast<std::size_t>(std::ranges::mismatch(a, b).in1 - a.begin());
  std::size_t begin = difference == 0 ? 0 : a.find_last_of(" ,{[", difference - 1) + 1;
  if (difference - begin > k_word) begin = difference;
  while (begin > 0 && begin < a.size() && is_continuation(a[begin])) --begin;
  const auto part = [begin](const std::string& text) {
    std::size_t end = std::min(begin + k_part, text.size());
    while (end < text.size() && is_continuation(text[end])) ++end;
    return (begin > 0 ? "..." : "") + text.substr(begin, end - begin) + (end < text.size() ? "..." : "");
  };
  return {part(a), part(b)};
}

}  // namespace

void check_fingerprint(const Fingerprint& made, const Fingerprint& asked, const std::string& file,
                       const FingerprintWords& words) {
  for (std::size_t i = 0; i < std::max(made.size(), asked.size()); ++i) {
    const FingerprintEntry none{"cloud", "none"};
    const FingerprintEntry &before = i < made.size() ? made[i] : none,
                           &now = i < asked.size() ? asked[i] : none;
    if (before == now) continue;
    const bool comparable = before.name == now.name;
    const auto [made_with, asked_for] = differing_parts(before.value, now.value);
    throw Error({.file = file,
                 .problem = fmt::format("this {} belongs to another {}: it has {} {}, {} has {}{}",
                                        words.file, words.of, before.name, made_with, words.other,
                                        comparable ? "" : now.name + " ", asked_for),
                 .expected = fmt::format("the same {}{}", words.same, words.remedy)});
  }
}

void append_fingerprint(const Fingerprint& fingerprint, std::vector<std::byte>& bytes) {
  for (const FingerprintEntry& entry : fingerprint) {
    std::size_t offset = bytes.size();
    bytes.resize(offset + k_lengths + entry.name.size() + entry.value.size());
    store(bytes.data() + offset, static_cast<std::uint32_t>(entry.name.size()));
    store(bytes.data() + offset + 4, static_cast<std::uint32_t>(entry.value.size()));
    offset += k_lengths;
    std::memcpy(bytes.data() + offset, entry.name.data(), entry.name.size());
    std::memcpy(bytes.data() + offset + entry.name.size(), entry.value.data(), entry.value.size());
  }
}

Fingerprint read_fingerprint(std::span<const std::byte> bytes, std::size_t offset, const std::string& file) {
  Fingerprint fingerprint;
  const auto text = [](std::span<const std::byte> part) {
    return std::string(reinterpret_cast<const char*>(part.data()), part.size());
  };
  while (!bytes.empty()) {
    std::uint64_t name = 0, value = 0;
    if (bytes.size() >= k_lengths) {
      name = load<std::uint32_t>(bytes.data());
      value = load<std::uint32_t>(bytes.data() + 4);
    }
    if (bytes.size() < k_lengths || name + value > bytes.size() - k_lengths)
      fail_at_byte(file, offset, "corrupt checkpoint: truncated fingerprint");
    fingerprint.push_back(
        {text(bytes.subspan(k_lengths, name)), text(bytes.subspan(k_lengths + name, value))});
    const std::size_t size = k_lengths + name + value;
    bytes = bytes.subspan(size);
    offset += size;
  }
  return fingerprint;
}

}  // namespace alidade
