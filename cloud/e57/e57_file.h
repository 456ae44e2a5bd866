// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/input_file.h"

namespace alidade {

/// CRC-32C (Castagnoli): polynomial 0x1EDC6F41, bits reflected, initial value and final XOR 0xFFFFFFFF, as in
/// iSCSI (RFC 3720). That of "123456789" is 0xE3069283. Cost: about a nanosecond per byte, by eight tables.
std::uint32_t crc32c(std::span<const std::byte> bytes);

/// Bytes of a page of an E57 file, and those of them that are not its checksum.
inline constexpr std::uint64_t k_e57_page = 1024;
inline constexpr std::uint64_t k_e57_payload = 1020;

/// The header of an E57 file, its first 48 bytes, without the signature.
struct E57Header {
  std::uint32_t version_major = 1, version_minor = 0;
  std::uint64_t xml_offset = 0;  ///< without checksums, as in E57Pages
  std::uint64_t xml_length = 0;  ///< without checksums
};

/// The bytes of an E57 file without the checksums between them: page after page, each compared with its
/// CRC-32C when it is read. Offsets in E57 files count the checksums ("physical"), lengths do not; here
/// offsets do not count them either, except where they are named physical. Not thread safe.
class E57Pages {
 public:
  /// Checks the file's header. Errors: it is not an E57 file, has another version than 1 or another page size
  /// than 1024, states another length than the file's, is not a whole number of pages, or its first page is
  /// damaged.
  explicit E57Pages(InputFile file);

  const E57Header& header() const { return header_; }
  const std::string& name() const { return file_.name(); }
  /// Bytes without checksums.
  std::uint64_t size() const { return file_.size() / k_e57_page * k_e57_payload; }
  /// Bytes with checksums.
  std::uint64_t file_size() const { return file_.size(); }

  /// The offset of a byte of the file. Errors: the byte belongs to a checksum or lies behind the end. `where`
  /// is the location and `what` the subject of the message.
  std::uint64_t offset_of(std::uint64_t physical, const std::string& where, const std::string& what) const;

  /// The bytes [offset, offset + count), valid until the next call. Errors: the file ends before; a page has
  /// a wrong checksum (the message names the page, counted from 0). Memory: the largest `count` requested,
  /// and some pages. Cost: with ascending offsets, each page is read and checked once.
  std::span<const std::byte> view(std::uint64_t offset, std::size_t count);

  /// Calls `take` with the bytes [offset, offset + count) in pieces, so that large sections need little
  /// memory. Errors: those of view().
  void visit(std::uint64_t offset, std::uint64_t count,
             const std::function<void(std::span<const std::byte>)>& take);

  /// Releases the file handle and the buffer; the next view() acquires them again.
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

/// Harmless oddities of a file, as clauses of a warning. Hundreds of scans may have the same oddity:
/// clauses() reports the first of each kind, and the number of others.
class E57Oddities {
 public:
  void add(const std::string& kind, const std::string& clause) {
    const auto [entry, is_first] = kinds_.try_emplace(kind, Kind{clause});
    if (!is_first) ++entry->second.more;
  }

  /// Sorted by kind.
  std::vector<std::string> clauses() const {
    std::vector<std::string> clauses;
    for (const auto& [name, kind] : kinds_) {
      clauses.push_back(kind.more == 0
                            ? kind.first
                            : kind.first + ", and " + std::to_string(kind.more) + " more like this");
    }
    return clauses;
  }

 private:
  struct Kind {
    std::string first;
    std::uint64_t more = 0;
  };
  std::map<std::string, Kind> kinds_;
};

// The XML of an E57 file as plain data. Standard: ASTM E2807.

/// How the values of a field are stored.
enum class E57FieldKind { integer, scaled_integer, float32, float64, text };

/// One value of every record of a scan.
struct E57Field {
  std::string name;  ///< with the prefix of its extension, if it has one
  E57FieldKind kind = E57FieldKind::float64;
  std::int64_t minimum = 0, maximum = 0;  ///< of stored integers
  double scale = 1.0, offset = 0.0;       ///< value = offset + scale * stored integer
  /// Smallest and largest value, where the file states both as finite numbers that are not only limits of a
  /// type: integers of 30 bits at most, scaled ones of 62, floats below 1e30.
  std::optional<std::array<double, 2>> range{};

  bool is_integer() const { return kind == E57FieldKind::integer || kind == E57FieldKind::scaled_integer; }
  /// Bits of a stored value, 0 (if all are equal) to 64. For texts, whose length varies, the fewest.
  int bits() const;
};

/// From the axes of a scan or image to those of the file: rotation * position + translation.
struct E57Pose {
  glm::dmat3 rotation{1.0};
  glm::dvec3 translation{0.0};
  bool is_rotated = false;  ///< whether the rotation is not the identity
};

/// Values of the darkest and the brightest colour or intensity that a scan can have; empty if not stated.
using E57Limits = std::optional<std::array<double, 2>>;

struct E57Scan {
  std::string name, guid;
  std::uint64_t record_count = 0;
  std::vector<E57Field> fields;  ///< in the order in which they are stored
  std::optional<E57Pose> pose{};
  E57Limits intensity_limits{};
  std::array<E57Limits, 3> color_limits{};  ///< red, green, blue
  std::optional<double> start{};            ///< seconds since the GPS epoch, 1980-01-06; empty if unknown

  // Where the records are, in bytes without checksums (E57Pages); 0 without records.
  std::uint64_t begin = 0;  ///< the section's header
  std::uint64_t end = 0;    ///< behind the section
  std::uint64_t first_packet = 0;
};

/// The contents of a binary section, such as an image file.
struct E57Blob {
  std::uint64_t offset = 0;  ///< of its first byte, without checksums
  std::uint64_t length = 0;
};

enum class E57Projection { visual, pinhole, spherical, cylindrical };

/// The word for each projection: "visual reference", "pinhole", ...
const char* name_of(E57Projection projection);

/// One representation of an image, which may have a visual reference and one of the projections.
struct E57Representation {
  E57Projection projection = E57Projection::visual;
  std::string extension;  ///< "jpg" or "png", by the first bytes; "bin" for anything else
  E57Blob blob;
  std::optional<E57Blob> mask{};                 ///< PNG, 0 = pixel not valid
  std::uint64_t width = 0, height = 0;           ///< pixels, as stated in the XML
  double focal_length = 0.0;                     ///< metres; pinhole
  double pixel_width = 0.0, pixel_height = 0.0;  ///< metres; spherical: radians; cylindrical: radians, metres
  double principal_x = 0.0, principal_y = 0.0;   ///< pixels; pinhole, cylindrical only y
  double radius = 0.0;                           ///< metres; cylindrical
};

struct E57Image {
  std::string name, guid, scan_guid;  ///< scan_guid: of the scan it belongs to, or empty
  std::optional<E57Pose> pose{};
  std::vector<E57Representation> representations;
};

struct E57Document {
  std::string guid;
  std::string coordinate_metadata;  ///< normally WKT; often empty
  std::vector<E57Scan> scans;
  std::vector<E57Image> images;
  E57Oddities oddities;
};

/// An E57 file whose XML is parsed and checked against the file: every section and every image lies inside
/// it, sections of scans do not overlap, and no scan has more records than its section can hold.
class E57File {
 public:
  /// Errors: those of E57Pages; XML that is damaged, has a document type, is larger than 64 MiB or has more
  /// than 8 million elements and attributes; content that docs/e57.md lists as rejected. They name page,
  /// scan, field or image. Memory: proportional to the size of the XML.
  explicit E57File(InputFile file);

  const E57Document& document() const { return document_; }
  E57Pages& pages() { return pages_; }
  const E57Pages& pages() const { return pages_; }

  /// Passes the bytes of a file inside the file to `take`, piece by piece. Errors: a damaged page.
  void read_blob(const E57Blob& blob, const std::function<void(std::span<const std::byte>)>& take) {
    pages_.visit(blob.offset, blob.length, take);
  }

 private:
  E57Pages pages_;
  E57Document document_;
};

}  // namespace alidade
