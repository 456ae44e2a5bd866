// SPDX-License-Identifier: MIT
#include "renderer/checkpoint_head.h"

#include <fmt/format.h>

#include <array>
#include <cstring>

#include "base/bytes.h"
#include "base/fingerprint.h"

namespace alidade {
namespace {

constexpr std::array<char, 8> k_magic = {'A', 'L', 'I', 'D', 'P', 'A', 'R', 'T'};
constexpr std::uint32_t k_byte_order = 0x01020304, k_other_byte_order = 0x04030201, k_version = 1;
constexpr std::size_t k_fixed_bytes = 80, k_checksum_place = 24;

std::uint64_t head_checksum(std::vector<std::byte> head) {
  store<std::uint64_t>(head.data() + k_checksum_place, 0);
  return checksum(head);
}

}  // namespace

std::vector<std::byte> encode_checkpoint_head(CheckpointHead& head) {
  std::vector<std::byte> bytes(k_fixed_bytes);
  append_identity(head.identity, bytes);
  head.head_bytes = bytes.size();
  std::byte* const at = bytes.data();
  store(at, k_magic);
  store(at + 8, k_byte_order);
  store(at + 12, k_version);
  store(at + 16, head.file_bytes);
  store(at + 32, head.rest_checksum);
  store(at + 40, head.width);
  store(at + 44, head.height);
  store<std::uint32_t>(at + 48, head.with_noise ? 1 : 0);
  store(at + 52, head.pass_end);
  store(at + 56, head.samples_taken);
  store(at + 64, head.seconds);
  store(at + 72, static_cast<std::uint32_t>(bytes.size() - k_fixed_bytes));
  store(at + 76, head.samples);
  store(at + k_checksum_place, head_checksum(bytes));
  return bytes;
}

bool begins_as_checkpoint(InputFile& file) {
  const auto start = file.view_up_to(0, k_magic.size());
  return start.size() == k_magic.size() && std::memcmp(start.data(), k_magic.data(), k_magic.size()) == 0;
}

CheckpointHead read_checkpoint_head(InputFile& file) {
  std::vector<std::byte> bytes(k_fixed_bytes);
  if (!begins_as_checkpoint(file))
    throw Error({.file = file.name(), .place = "byte 0", .problem = "is not a checkpoint of Alidade"});
  file.read_at(0, bytes);
  {
    const HeaderFields fixed(bytes, file.name());
    const auto order = fixed.get<std::uint32_t>(8);
    fixed.require(order != k_other_byte_order, 8, "comes from a machine of another byte order",
                  "little endian", "big endian");
    fixed.require(order == k_byte_order, 8, "bad byte order mark", "01020304", fmt::format("{:08x}", order));
    const auto version = fixed.get<std::uint32_t>(12);
    fixed.require(version == k_version, 12, "another version of checkpoints", std::to_string(k_version),
                  version);
    const auto size = fixed.get<std::uint64_t>(16);
    fixed.require(size == file.size(), 16, "is cut short or too long", fmt::format("{} bytes", size),
                  file.size());
    const std::uint64_t identity_bytes = fixed.get<std::uint32_t>(72);
    fixed.require(identity_bytes <= file.size() - k_fixed_bytes, 72, "is damaged",
                  fmt::format("at most {} bytes of description", file.size() - k_fixed_bytes),
                  identity_bytes);
    bytes.resize(k_fixed_bytes + identity_bytes);
  }
  file.read_at(k_fixed_bytes, std::span(bytes).subspan(k_fixed_bytes));
  const HeaderFields reader(bytes, file.name());
  const std::uint64_t sum = head_checksum(bytes);
  reader.require(reader.get<std::uint64_t>(k_checksum_place) == sum, k_checksum_place,
                 "is damaged: the head has another checksum",
                 fmt::format("{:016x}", reader.get<std::uint64_t>(k_checksum_place)),
                 fmt::format("{:016x}", sum));
  CheckpointHead head;
  head.file_bytes = reader.get<std::uint64_t>(16);
  head.rest_checksum = reader.get<std::uint64_t>(32);
  head.width = reader.get<std::uint32_t>(40);
  head.height = reader.get<std::uint32_t>(44);
  const auto with_noise = reader.get<std::uint32_t>(48);
  reader.require(with_noise <= 1, 48, "is damaged", "0 or 1", with_noise);
  head.with_noise = with_noise == 1;
  head.pass_end = reader.get<std::uint32_t>(52);
  head.samples_taken = reader.get<std::uint64_t>(56);
  head.seconds = reader.get<double>(64);
  reader.require(head.seconds >= 0.0 && head.seconds < 1e12, 64, "is damaged", "seconds", head.seconds);
  head.samples = reader.get<std::uint32_t>(76);
  head.identity = read_identity(std::span(bytes).subspan(k_fixed_bytes), k_fixed_bytes, file.name());
  head.head_bytes = bytes.size();
  return head;
}

}  // namespace alidade
