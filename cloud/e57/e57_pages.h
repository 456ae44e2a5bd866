// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/input_file.h"

namespace alidade {

/// CRC-32C (Castagnoli): polynomial 0x1EDC6F41, bits reflected, begun with and inverted by 0xFFFFFFFF, as in
/// iSCSI (RFC 3720). That of "123456789" is 0xE3069283. Cost: about a nanosecond per byte, by eight tables.
std::uint32_t crc32c(std::span<const std::byte> bytes);

/// Bytes of a page of an E57 file, and those of them that are not its checksum.
inline constexpr std::uint64_t k_e57_page = 1024;
inline constexpr std::uint64_t k_e57_payload = 1020;

/// What the first 48 bytes of an E57 file say beside its signature.
struct E57Header {
  std::uint32_t version_major = 1, version_minor = 0;
  std::uint64_t xml_offset = 0;  ///< byte of the file
  std::uint64_t xml_length = 0;  ///< without checksums
};

/// The bytes of an E57 file without the checksums between them: page after page, each compared with its
/// CRC-32C when it is read. Offsets in E57 files count the checksums ("physical"), lengths do not; here offsets
/// are those among the bytes without checksums, unless a name says otherwise. Not thread safe.
class E57Pages {
 public:
  /// Checks the file's header. Errors: it is no E57 file, another version or page size than 1 and 1024, a
  /// length that is not the file's or no whole number of pages, a damaged first page.
  explicit E57Pages(InputFile file);

  const E57Header& header() const { return header_; }
  const std::string& name() const { return file_.name(); }
  /// Bytes without checksums.
  std::uint64_t size() const { return file_.size() / k_e57_page * k_e57_payload; }
  /// Bytes with checksums.
  std::uint64_t file_size() const { return file_.size(); }

  /// The offset of a byte of the file. Errors: it belongs to a checksum or lies behind the end; `where` is the
  /// offset and `what` the subject of the message.
  std::uint64_t offset_of(std::uint64_t physical, const std::string& where, const std::string& what) const;

  /// The bytes [offset, offset + count), valid until the next call. Errors: they are not all there; a page's
  /// checksum is wrong, which names the page, counted from 0. Memory: the largest `count` asked for and some
  /// pages. Cost: who goes forward has each page read and compared once.
  std::span<const std::byte> view(std::uint64_t offset, std::size_t count);

  /// Gives `count` bytes from `offset` on to `take`, in pieces, so that a large file inside the file needs
  /// little memory. Errors: those of view().
  void visit(std::uint64_t offset, std::uint64_t count,
             const std::function<void(std::span<const std::byte>)>& take);

  /// Gives back file handle and buffer until the next view().
  void rest();

  [[noreturn]] void fail(std::string where, std::string problem, std::string expected = {},
                         std::string found = {}) const;

 private:
  void fill(std::uint64_t first_page, std::uint64_t page_count);

  InputFile file_;
  E57Header header_;
  std::vector<std::byte> window_;  ///< payload of the pages from window_page_ on
  std::uint64_t window_page_ = 0;
};

}  // namespace alidade
