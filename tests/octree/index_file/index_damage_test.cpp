// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <limits>

#include "octree/index_file/index_file.h"
#include "octree/index_file/index_header.h"
#include "tests/octree/index_file/damaged_index.h"

namespace alidade {
namespace {

using test::error_of;
using test::put;
using test::seal_header;
using test::SectionRow;

using test::Bytes;
using test::is_rejected;
using test::is_rejected_when_opened;
using test::is_rejected_when_verified;
using test::section;
using test::sound_file;

TEST(IndexDamage, a_sound_file_is_not_rejected) {
  Bytes file = sound_file();
  EXPECT_FALSE(is_rejected(file));
  EXPECT_FALSE(is_rejected_when_verified(file));
  // Sealing it again changes nothing, so that tests that seal a file test only their own change.
  test::seal(file);
  EXPECT_EQ(file, sound_file());
}

TEST(IndexDamage, a_file_cut_off_anywhere_is_an_error_when_opened) {
  const Bytes& file = sound_file();
  std::vector<std::size_t> lengths = {0, 1, 7, 8, 9, 255, 256, 4095, 4096, 4097, file.size() - 1};
  for (const SectionRow& row : test::section_rows(file)) {
    for (const std::uint64_t offset : {row.offset, row.offset + row.bytes}) {
      for (const int step : {-1, 0, 1}) lengths.push_back(static_cast<std::size_t>(offset) + step);
    }
  }
  test::Random random;
  for (int i = 0; i < 300; ++i) lengths.push_back(random.below(file.size()));
  for (const std::size_t length : lengths) {
    if (length >= file.size()) continue;
    EXPECT_TRUE(
        is_rejected_when_opened(Bytes(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(length))))
        << length;
  }
}

TEST(IndexDamage, bytes_behind_the_end_are_an_error_when_opened) {
  Bytes file = sound_file();
  file.push_back(std::byte{0});
  EXPECT_NE(error_of([&] { test::index_in_memory(file); }).find("too long"), std::string::npos);
}

TEST(IndexDamage, a_flipped_bit_in_any_byte_of_the_header_is_an_error_when_opened) {
  Bytes file = sound_file();
  for (std::size_t offset = 0; offset < 4096; ++offset) {
    const std::byte mask{static_cast<unsigned char>(1u << offset % 8)};
    file[offset] ^= mask;
    EXPECT_TRUE(is_rejected_when_opened(file)) << offset;
    file[offset] ^= mask;
  }
}

TEST(IndexDamage, a_flipped_bit_anywhere_is_found_by_verifying_and_does_no_harm_without) {
  Bytes file = sound_file();
  test::Random random;
  for (int i = 0; i < 1500; ++i) {
    const std::size_t offset = random.below(file.size());
    const std::byte mask{static_cast<unsigned char>(1u << random.below(8))};
    file[offset] ^= mask;
    EXPECT_TRUE(is_rejected_when_verified(file)) << offset;
    is_rejected(file);
    file[offset] ^= mask;
  }
}

TEST(IndexDamage, a_wrong_checksum_of_any_section_in_the_header_is_found_by_verifying) {
  const Bytes& sound = sound_file();
  for (const SectionRow& row : test::section_rows(sound)) {
    Bytes file = sound;
    put(file, row.row + 24, test::get<std::uint64_t>(file, row.row + 24) ^ 1);
    seal_header(file);
    const auto kind = static_cast<IndexSection>(row.kind);
    const std::string expected = kind == IndexSection::checksums
                                     ? "its checksum differs from the one in the header"
                                     : "wrong checksum of the checksums of section " + name(kind);
    const std::string message = error_of([&] { test::index_in_memory(file).verify(); });
    EXPECT_NE(message.find("corrupt section checksums: " + expected), std::string::npos) << message;
  }
}

TEST(IndexDamage, a_flipped_bit_in_nodes_or_ids_is_an_error_before_the_first_query) {
  Bytes file = sound_file();
  test::Random random;
  for (const IndexSection kind : {IndexSection::nodes, IndexSection::ids}) {
    const SectionRow row = section(file, kind);
    for (int i = 0; i < 100; ++i) {
      const std::size_t offset = row.offset + random.below(row.bytes);
      file[offset] ^= std::byte{4};
      const IndexFile index = test::index_in_memory(file);
      const std::string message = error_of([&] { index.octree(); });
      EXPECT_NE(message.find("corrupt section " + name(kind)), std::string::npos) << message;
      EXPECT_NE(message.find("memory:byte " + std::to_string(row.offset)), std::string::npos) << message;
      file[offset] ^= std::byte{4};
    }
  }
}

TEST(IndexDamage, a_flipped_bit_in_the_metadata_is_an_error_when_opened) {
  Bytes file = sound_file();
  const SectionRow row = section(file, IndexSection::metadata);
  for (std::uint64_t offset = row.offset; offset < row.offset + row.bytes; ++offset) {
    file[offset] ^= std::byte{1};
    EXPECT_TRUE(is_rejected_when_opened(file)) << offset;
    file[offset] ^= std::byte{1};
  }
}

TEST(IndexDamage, another_byte_order_another_version_and_another_file_are_told_apart) {
  Bytes file = sound_file();
  put<std::uint32_t>(file, 8, 0x04030201);
  EXPECT_NE(error_of([&] { test::index_in_memory(file); }).find("wrong byte order"), std::string::npos);
  for (const std::uint32_t version : {1u, 3u}) {
    file = sound_file();
    put<std::uint32_t>(file, 12, version);
    const std::string message = error_of([&] { test::index_in_memory(file); });
    EXPECT_NE(message.find("unsupported index file version; expected version 2 (create the file again with "
                           "'alidade index')"),
              std::string::npos)
        << message;
    EXPECT_NE(message.find("found version " + std::to_string(version)), std::string::npos) << message;
  }
  file = sound_file();
  file[3] = std::byte{'x'};
  EXPECT_NE(error_of([&] { test::index_in_memory(file); }).find("not an Alidade index file"),
            std::string::npos);
}

TEST(IndexDamage, counts_larger_than_the_file_are_errors_when_opened) {
  for (const std::size_t offset : {40, 48}) {
    for (const std::uint64_t count : {std::uint64_t{100000}, std::uint64_t{0xfffffffe},
                                      std::uint64_t{1} << 58, std::numeric_limits<std::uint64_t>::max()}) {
      Bytes file = sound_file();
      put(file, offset, count);
      seal_header(file);
      EXPECT_TRUE(is_rejected_when_opened(file)) << offset << " " << count;
    }
  }
}

TEST(IndexDamage, overlapping_sections_and_gaps_between_them_are_errors_when_opened) {
  const Bytes& sound = sound_file();
  const std::vector<SectionRow> rows = test::section_rows(sound);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    for (const std::uint64_t offset : {rows[i - 1].offset, rows[i].offset - 4096, rows[i].offset - 1,
                                       rows[i].offset + 1, rows[i].offset + 4096}) {
      Bytes file = sound;
      put(file, rows[i].row + 8, offset);
      seal_header(file);
      EXPECT_TRUE(is_rejected_when_opened(file)) << i << " " << offset;
    }
    Bytes swapped = sound;
    put(swapped, rows[i].row, rows[i - 1].kind);
    put(swapped, rows[i - 1].row, rows[i].kind);
    seal_header(swapped);
    EXPECT_TRUE(is_rejected_when_opened(swapped)) << i;
  }
}

TEST(IndexDamage, something_between_the_sections_is_found_by_verifying) {
  Bytes file = sound_file();
  const SectionRow row = section(file, IndexSection::coordinates);
  file[row.offset - 1] = std::byte{1};
  EXPECT_NE(error_of([&] { test::index_in_memory(file).verify(); }).find("before section coordinates"),
            std::string::npos);
}

TEST(IndexDamage, files_on_disk_are_named_with_the_damaged_byte) {
  const auto path = test::test_folder() / "site.alidade";
  Bytes file = sound_file();
  file[64] ^= std::byte{1};
  test::write_bytes(path, file);
  EXPECT_NE(
      error_of([&] { open_index(path); }).find(path.string() + ":byte 32: corrupt header: wrong checksum"),
      std::string::npos);
  test::write_bytes(path, {});
  EXPECT_NE(error_of([&] { open_index(path); }).find("not an Alidade index file"), std::string::npos);
  EXPECT_NE(error_of([&] { open_index(path.parent_path()); }).find("a regular file"), std::string::npos);
  EXPECT_NE(error_of([&] { open_index(path.parent_path() / "absent"); }).find("cannot open the file"),
            std::string::npos);
}

}  // namespace
}  // namespace alidade
