// SPDX-License-Identifier: MIT
#include "octree/index_file/index_sections.h"

#include <fmt/format.h>
#include <algorithm>

#include "base/error.h"
#include "base/fingerprint.h"
#include "base/huge_memory.h"
#include "base/local_map.h"
#include "base/parallel.h"

namespace alidade {
namespace {

// So many blocks are summed between two reports: tens of milliseconds.
constexpr std::uint64_t k_blocks_per_report = 256;

}  // namespace

IndexSections::IndexSections(const InputFile& file)
    : map_(file.is_remote() ? MappedBytes() : file.map()),
      file_(file.is_remote() ? InputFile(file.address()) : InputFile(map_.bytes, file.name())),
      header_(read_index_header(file_.view_up_to(0, k_index_page), file_.size(), name())) {}

void IndexSections::map(const Progress& progress) {
  if (!is_mapped()) map_ = file_.map(progress);
}

std::vector<std::byte> IndexSections::read(IndexSection kind) const {
  const SectionEntry* const section = header_.find(kind);
  if (section == nullptr) return {};
  check_memory(section->bytes, "a section of an index file");
  std::vector<std::byte> all(static_cast<std::size_t>(section->bytes));
  {
    const std::scoped_lock lock(reading_);
    file_.read_at(section->offset, all);
  }
  check_blocks(kind, all, {}, {});
  return all;
}

std::span<const std::byte> IndexSections::bytes(IndexSection kind) const {
  const SectionEntry* const section = header_.find(kind);
  if (section == nullptr) return {};
  return map_.bytes.subspan(static_cast<std::size_t>(section->offset),
                            static_cast<std::size_t>(section->bytes));
}

void IndexSections::fail(IndexSection kind, std::uint64_t byte, const std::string& problem) const {
  throw Error({.file = name(),
               .location = fmt::format("byte {}", entry(kind).offset + byte),
               .problem = fmt::format("corrupt section {}: {}", alidade::name(kind), problem)});
}

std::vector<std::uint64_t> IndexSections::stored_checksums(IndexSection kind) const {
  std::uint64_t first = 0;
  for (const SectionEntry& section : header_.sections) {
    if (section.kind == kind) break;
    first += checksum_blocks(section.bytes);
  }
  // What is checked is what is used.
  std::vector<std::uint64_t> run(static_cast<std::size_t>(checksum_blocks(entry(kind).bytes)));
  {
    const std::scoped_lock lock(reading_);
    file_.read_at(entry(IndexSection::checksums).offset + first * sizeof(std::uint64_t),
                  std::as_writable_bytes(std::span(run)));
  }
  if (checksum(std::as_bytes(std::span(run))) != entry(kind).checksum) {
    fail(IndexSection::checksums, first * sizeof(std::uint64_t),
         fmt::format("wrong checksum of the checksums of section {}", alidade::name(kind)));
  }
  return run;
}

void IndexSections::check(IndexSection kind, const Progress& progress, const LookAtBlock& look) const {
  const SectionEntry* const section = header_.find(kind);
  if (section == nullptr) return;
  const std::span<const std::byte> all = bytes(kind);
  if (kind == IndexSection::checksums) {
    expect_reads(all);
    if (checksum(all) != section->checksum) fail(kind, 0, "its checksum differs from the one in the header");
    return;
  }
  check_blocks(kind, all, progress, look);
}

void IndexSections::check_blocks(IndexSection kind, std::span<const std::byte> all, const Progress& progress,
                                 const LookAtBlock& look) const {
  const std::vector<std::uint64_t> stored = stored_checksums(kind);
  for (std::uint64_t begin = 0; begin < stored.size(); begin += k_blocks_per_report) {
    const std::uint64_t end = std::min<std::uint64_t>(begin + k_blocks_per_report, stored.size());
    expect_reads(
        all.subspan(begin * k_checksum_block,
                    std::min<std::uint64_t>(end * k_checksum_block, all.size()) - begin * k_checksum_block));
    in_parallel(end - begin, 1, [&](std::uint64_t i) {
      const std::uint64_t block = begin + i;
      const std::span<const std::byte> part = checksum_block(all, static_cast<std::size_t>(block));
      const std::uint64_t byte = block * k_checksum_block;
      if (checksum(part) != stored[static_cast<std::size_t>(block)])
        fail(kind, byte, fmt::format("checksum mismatch in the next {} bytes", part.size()));
      if (look) look(byte, byte + part.size());
    });
    report(progress, std::min<std::uint64_t>(end * k_checksum_block, all.size()), all.size());
  }
}

void IndexSections::check_gaps() const {
  std::uint64_t byte = k_index_page;
  for (const SectionEntry& section : header_.sections) {
    for (; byte < section.offset; ++byte) {
      if (map_.bytes[static_cast<std::size_t>(byte)] == std::byte{0}) continue;
      throw Error(
          {.file = name(),
           .location = fmt::format("byte {}", byte),
           .problem = fmt::format("the gap before section {} is not zero", alidade::name(section.kind)),
           .expected = "zeros up to the next multiple of 4096"});
    }
    byte = section.end();
  }
}

}  // namespace alidade
