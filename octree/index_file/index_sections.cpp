// SPDX-License-Identifier: MIT
#include "octree/index_file/index_sections.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <mutex>

#include "base/error.h"
#include "base/fingerprint.h"

namespace alidade {
namespace {

constexpr std::uint64_t k_none = std::numeric_limits<std::uint64_t>::max();

// So many blocks are summed between two reports: tens of milliseconds.
constexpr std::uint64_t k_blocks_per_report = 256;

}  // namespace

std::span<const std::byte> IndexSections::bytes(IndexSection kind) const {
  const SectionEntry* const section = header_.find(kind);
  if (section == nullptr) return {};
  return map_.bytes().subspan(static_cast<std::size_t>(section->place),
                              static_cast<std::size_t>(section->bytes));
}

void IndexSections::fail(IndexSection kind, std::uint64_t byte, const std::string& problem) const {
  throw Error({.file = map_.name(),
               .place = fmt::format("byte {}", entry(kind).place + byte),
               .problem = fmt::format("section {} is damaged: {}", alidade::name(kind), problem)});
}

std::span<const std::uint64_t> IndexSections::stored_checksums(IndexSection kind) const {
  std::uint64_t first = 0;
  for (const SectionEntry& section : header_.sections) {
    if (section.kind == kind) break;
    first += checksum_blocks(section.bytes);
  }
  const auto run = values<std::uint64_t>(IndexSection::checksums)
                       .subspan(static_cast<std::size_t>(first),
                                static_cast<std::size_t>(checksum_blocks(entry(kind).bytes)));
  if (checksum(std::as_bytes(run)) != entry(kind).checksum) {
    fail(IndexSection::checksums, first * sizeof(std::uint64_t),
         fmt::format("the checksums of section {} do not have the checksum in the header",
                     alidade::name(kind)));
  }
  return run;
}

void IndexSections::check(IndexSection kind, const Progress& progress, const LookAtBlock& look) const {
  const SectionEntry* const section = header_.find(kind);
  if (section == nullptr) return;
  const std::span<const std::byte> all = bytes(kind);
  if (kind == IndexSection::checksums) {
    if (checksum(all) != section->checksum) fail(kind, 0, "its checksum is not the one in the header");
    return;
  }
  const std::span<const std::uint64_t> stored = stored_checksums(kind);
  for (std::uint64_t begin = 0; begin < stored.size(); begin += k_blocks_per_report) {
    const std::uint64_t end = std::min<std::uint64_t>(begin + k_blocks_per_report, stored.size());
    std::atomic<std::uint64_t> first_bad = k_none;
    const auto check_block = [&](std::uint64_t block) {
      const std::span<const std::byte> part = checksum_block(all, static_cast<std::size_t>(block));
      if (checksum(part) != stored[static_cast<std::size_t>(block)]) {
        std::uint64_t bad = first_bad;
        while (block < bad && !first_bad.compare_exchange_weak(bad, block)) {
        }
      } else if (look) {
        look(block * k_checksum_block, block * k_checksum_block + part.size());
      }
    };
    // Calling for threads takes longer than a single block.
    if (end - begin == 1) {
      check_block(begin);
    } else {
      tbb::parallel_for(begin, end, check_block);
    }
    if (first_bad != k_none) {
      const std::uint64_t byte = first_bad * k_checksum_block;
      fail(kind, byte,
           fmt::format("the checksum of the {} bytes from here on is wrong",
                       std::min<std::uint64_t>(all.size() - byte, k_checksum_block)));
    }
    report(progress, std::min<std::uint64_t>(end * k_checksum_block, all.size()), all.size());
  }
}

void IndexSections::check_gaps() const {
  std::uint64_t place = k_index_page;
  for (const SectionEntry& section : header_.sections) {
    for (; place < section.place; ++place) {
      if (map_.bytes()[static_cast<std::size_t>(place)] == std::byte{0}) continue;
      throw Error({.file = map_.name(),
                   .place = fmt::format("byte {}", place),
                   .problem = fmt::format("something stands before section {}", alidade::name(section.kind)),
                   .expected = "zeros up to the next multiple of 4096"});
    }
    place = section.end();
  }
}

}  // namespace alidade
