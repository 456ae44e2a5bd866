// SPDX-License-Identifier: MIT
#include "octree/index_file/index_sections.h"

#include <fmt/format.h>
#include <algorithm>

#include "base/error.h"
#include "base/fingerprint.h"
#include "base/parallel.h"
#include "octree/index_file/check_tree.h"

namespace alidade {
namespace {

// So many blocks are summed between two reports: tens of milliseconds.
constexpr std::uint64_t k_blocks_per_report = 256;

[[noreturn]] void fail_in(const std::string& file, const SectionEntry& section, std::uint64_t byte,
                          const std::string& problem) {
  throw Error({.file = file,
               .location = fmt::format("byte {}", section.offset + byte),
               .problem = fmt::format("corrupt section {}: {}", name(section.kind), problem)});
}

std::string wrong_sum(std::uint64_t bytes) {
  return fmt::format("checksum mismatch in the next {} bytes", bytes);
}

/// A section of a remote file, with the checksums of its blocks.
struct ArrivingSection {
  SectionEntry entry;
  std::vector<std::uint64_t> sums;

  std::pair<std::uint64_t, std::uint64_t> block_of(std::uint64_t offset) const {
    const std::uint64_t begin = entry.offset + (offset - entry.offset) / k_checksum_block * k_checksum_block;
    return {begin, std::min(begin + k_checksum_block, entry.end())};
  }

  void check(std::uint64_t offset, std::span<const std::byte> bytes, std::uint64_t point_count,
             const std::string& file) const {
    const std::uint64_t from = offset - entry.offset;
    const auto block =
        bytes.first(static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), entry.bytes - from)));
    if (checksum(block) != sums[static_cast<std::size_t>(from / k_checksum_block)])
      fail_in(file, entry, from, wrong_sum(block.size()));
    if (entry.kind != IndexSection::ids) return;
    // Blocks arrive in memory of std::vector, aligned for any value.
    const std::span ids(reinterpret_cast<const std::uint32_t*>(block.data()),
                        block.size() / sizeof(std::uint32_t));
    if (const auto bad = find_bad_id(ids, point_count))
      fail_in(file, entry, from + bad->index * sizeof(std::uint32_t), bad->problem);
  }
};

/// Before it is mapped: a server may claim any size.
IndexHeader header_of(InputFile file) {
  const std::uint64_t size = file.size();
  return read_index_header(file.view_up_to(0, k_index_page), size, file.name());
}

}  // namespace

IndexSections::IndexSections(const InputFile& file)
    : header_(file.is_remote() ? header_of(InputFile(file.address())) : IndexHeader()), map_(file) {
  const std::span<const std::byte> all = map_.bytes();
  if (!file.is_remote()) {
    header_ = read_index_header(all.first(std::min(all.size(), k_index_page)), all.size(), name());
    return;
  }
  if (all.size() != header_.file_bytes)
    throw file_error(name(), "the file changed while it was read; read it again",
                     fmt::format("{} bytes", header_.file_bytes), fmt::format("{}", all.size()));
  if (const auto remote = RemoteMap::find(all.data())) check_on_arrival(*remote);
}

void IndexSections::check_on_arrival(RemoteMap& map) {
  check(IndexSection::checksums);
  std::vector<ArrivingSection> sections;
  // Not the checksums, which are there.
  for (const SectionEntry& section : header_.sections) {
    if (section.kind == IndexSection::checksums || section.bytes == 0) continue;
    sections.push_back({section, stored_checksums(section.kind)});
  }
  const auto all = std::make_shared<const std::vector<ArrivingSection>>(std::move(sections));
  const auto section_of = [all](std::uint64_t offset) -> const ArrivingSection* {
    for (const ArrivingSection& section : *all)
      if (offset >= section.entry.offset && offset < align_to_page(section.entry.end())) return &section;
    return nullptr;
  };
  map.set_blocks(
      [section_of](std::uint64_t offset) {
        const ArrivingSection* const section = section_of(offset);
        const std::uint64_t page = offset / k_index_page * k_index_page;
        return section != nullptr ? section->block_of(std::min(offset, section->entry.end() - 1))
                                  : std::pair(page, page + k_index_page);
      },
      [section_of, points = header_.tree.point_count, name = map_.name()](std::uint64_t offset,
                                                                          std::span<const std::byte> bytes) {
        if (const ArrivingSection* const section = section_of(offset))
          section->check(offset, bytes, points, name);
      });
  are_checked_on_arrival_ = true;
}

std::span<const std::byte> IndexSections::bytes(IndexSection kind) const {
  const SectionEntry* const section = header_.find(kind);
  if (section == nullptr) return {};
  return map_.bytes().subspan(static_cast<std::size_t>(section->offset),
                              static_cast<std::size_t>(section->bytes));
}

void IndexSections::fail(IndexSection kind, std::uint64_t byte, const std::string& problem) const {
  fail_in(map_.name(), entry(kind), byte, problem);
}

std::vector<std::uint64_t> IndexSections::stored_checksums(IndexSection kind) const {
  std::uint64_t first = 0;
  for (const SectionEntry& section : header_.sections) {
    if (section.kind == kind) break;
    first += checksum_blocks(section.bytes);
  }
  const auto stored = values<std::uint64_t>(IndexSection::checksums)
                          .subspan(static_cast<std::size_t>(first),
                                   static_cast<std::size_t>(checksum_blocks(entry(kind).bytes)));
  // What is checked is what is used.
  const std::vector<std::uint64_t> run(stored.begin(), stored.end());
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
    MappedFile::fetch(all);
    RemoteMap::check(all.data());
    if (checksum(all) != section->checksum) fail(kind, 0, "its checksum differs from the one in the header");
    return;
  }
  const std::vector<std::uint64_t> stored = stored_checksums(kind);
  for (std::uint64_t begin = 0; begin < stored.size(); begin += k_blocks_per_report) {
    const std::uint64_t end = std::min<std::uint64_t>(begin + k_blocks_per_report, stored.size());
    MappedFile::fetch(
        all.subspan(begin * k_checksum_block,
                    std::min<std::uint64_t>(end * k_checksum_block, all.size()) - begin * k_checksum_block));
    RemoteMap::check(all.data());
    in_parallel(end - begin, 1, [&](std::uint64_t i) {
      const std::uint64_t block = begin + i;
      const std::span<const std::byte> part = checksum_block(all, static_cast<std::size_t>(block));
      const std::uint64_t byte = block * k_checksum_block;
      if (checksum(part) != stored[static_cast<std::size_t>(block)]) fail(kind, byte, wrong_sum(part.size()));
      if (look) look(byte, byte + part.size());
    });
    report(progress, std::min<std::uint64_t>(end * k_checksum_block, all.size()), all.size());
  }
}

void IndexSections::check_gaps() const {
  std::uint64_t byte = k_index_page;
  for (const SectionEntry& section : header_.sections) {
    for (; byte < section.offset; ++byte) {
      if (map_.bytes()[static_cast<std::size_t>(byte)] == std::byte{0}) continue;
      throw Error(
          {.file = map_.name(),
           .location = fmt::format("byte {}", byte),
           .problem = fmt::format("the gap before section {} is not zero", alidade::name(section.kind)),
           .expected = "zeros up to the next multiple of 4096"});
    }
    byte = section.end();
  }
}

}  // namespace alidade
