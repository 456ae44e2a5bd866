// SPDX-License-Identifier: MIT
#include "cloud/e57/e57_file.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <numeric>

#include "base/bytes.h"
#include "base/error.h"
#include "cloud/e57/e57_xml.h"
#include "cloud/point_table.h"

namespace alidade {
namespace {

using Tables = std::array<std::array<std::uint32_t, 256>, 8>;

/// tables[k][b]: the effect of byte b on the sum if k more bytes follow it.
constexpr Tables k_tables = [] {
  constexpr std::uint32_t k_reflected_polynomial = 0x82F63B78;
  Tables tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t sum = byte;
    for (int bit = 0; bit < 8; ++bit) sum = (sum >> 1) ^ ((sum & 1) != 0 ? k_reflected_polynomial : 0);
    tables[0][byte] = sum;
  }
  for (std::size_t k = 1; k < 8; ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t sum = tables[k - 1][byte];
      tables[k][byte] = (sum >> 8) ^ tables[0][sum & 255];
    }
  }
  return tables;
}();

constexpr std::size_t k_header_bytes = 48;
constexpr std::uint64_t k_window_pages = 32;

constexpr std::uint64_t k_largest_xml = std::uint64_t{64} << 20;
constexpr std::ptrdiff_t k_most_nodes = 8'000'000;

/// The text of the XML, without the padding of writers behind it.
std::string read_xml(E57Pages& pages) {
  const E57Header& header = pages.header();
  if (header.xml_length > k_largest_xml) {
    pages.fail("XML", "the XML is too long", fmt::format("at most {} bytes", k_largest_xml),
               std::to_string(header.xml_length));
  }
  std::string text;
  text.reserve(static_cast<std::size_t>(header.xml_length));
  pages.visit(header.xml_offset, header.xml_length, [&](std::span<const std::byte> bytes) {
    text.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  });
  text.resize(text.find_last_not_of(std::string_view(" \t\r\n\0", 5)) + 1);
  // Every element has a "<", every attribute a "=": this bounds the memory of the parser.
  const auto nodes = std::ranges::count(text, '<') + std::ranges::count(text, '=');
  if (nodes > k_most_nodes)
    pages.fail("XML", "too many elements", fmt::format("at most {}", k_most_nodes), std::to_string(nodes));
  return text;
}

void parse(const E57Pages& pages, std::string& text, pugi::xml_document& xml) {
  const auto result = xml.load_buffer_inplace(
      text.data(), text.size(),
      pugi::parse_cdata | pugi::parse_escapes | pugi::parse_eol | pugi::parse_doctype, pugi::encoding_utf8);
  if (!result) {
    pages.fail(fmt::format("XML, byte {}", result.offset),
               std::string("invalid XML: ") + result.description());
  }
  for (const pugi::xml_node& node : xml.children()) {
    if (node.type() == pugi::node_doctype) pages.fail("XML", "unsupported document type", "none");
  }
}

/// Checks that sections do not overlap: scans that share bytes would let a small file have any number of
/// points.
void check_overlap(const E57Pages& pages, const std::vector<E57Scan>& scans) {
  std::vector<std::size_t> order(scans.size());
  std::iota(order.begin(), order.end(), 0);
  std::erase_if(order, [&](std::size_t i) { return scans[i].record_count == 0; });
  std::ranges::sort(order, {}, [&](std::size_t i) { return scans[i].begin; });
  for (std::size_t i = 1; i < order.size(); ++i) {
    const E57Scan &before = scans[order[i - 1]], &scan = scans[order[i]];
    if (scan.begin >= before.end) continue;
    pages.fail(fmt::format("scan {}", order[i] + 1),
               fmt::format("the section overlaps that of scan {}", order[i - 1] + 1),
               fmt::format("a start at {} or later", before.end), std::to_string(scan.begin));
  }
}

/// Checks that the images are not larger than the file, since they are written to files one by one.
void check_image_sizes(const E57Pages& pages, const std::vector<E57Image>& images) {
  std::uint64_t left = pages.size();
  for (std::size_t i = 0; i < images.size(); ++i) {
    for (const E57Representation& representation : images[i].representations) {
      const std::uint64_t length =
          representation.blob.length + (representation.mask ? representation.mask->length : 0);
      if (length > left) pages.fail(fmt::format("image {}", i + 1), "the images exceed the file");
      left -= length;
    }
  }
}

E57Document read_document(E57Pages& pages) {
  std::string text = read_xml(pages);
  pugi::xml_document xml;
  parse(pages, text, xml);
  const E57Node root(pages, xml.child("e57Root"), "XML");
  if (!root) root.fail("missing element e57Root");
  E57Document document;
  document.guid = root.child("guid").text();
  document.coordinate_metadata = root.child("coordinateMetadata").text();
  for (const pugi::xml_node& scan : root.child("data3D").element().children("vectorChild")) {
    const E57Node node(pages, scan, fmt::format("scan {}", document.scans.size() + 1));
    document.scans.push_back(read_e57_scan(node, pages, document.oddities));
  }
  for (const pugi::xml_node& image : root.child("images2D").element().children("vectorChild")) {
    const E57Node node(pages, image, fmt::format("image {}", document.images.size() + 1));
    document.images.push_back(read_e57_image(node, pages, document.oddities));
  }
  check_overlap(pages, document.scans);
  check_image_sizes(pages, document.images);
  return document;
}

}  // namespace

std::uint32_t crc32c(std::span<const std::byte> bytes) {
  std::uint32_t sum = 0xFFFFFFFF;
  while (bytes.size() >= 8) {
    const std::uint64_t word = load<std::uint64_t>(bytes.data()) ^ sum;
    sum = 0;
    for (std::size_t k = 0; k < 8; ++k) sum ^= k_tables[7 - k][word >> (8 * k) & 255];
    bytes = bytes.subspan(8);
  }
  for (const std::byte byte : bytes)
    sum = (sum >> 8) ^ k_tables[0][(sum ^ std::to_integer<std::uint32_t>(byte)) & 255];
  return ~sum;
}

E57Pages::E57Pages(InputFile file) : file_(std::move(file)) {
  std::array<std::byte, k_header_bytes> bytes;
  if (file_.size() < k_header_bytes)
    fail("header", "truncated file", "48 bytes", std::to_string(file_.size()));
  file_.read_at(0, bytes);
  if (std::memcmp(bytes.data(), "ASTM-E57", 8) != 0)
    fail("header", "not an E57 file", "ASTM-E57 at the start");
  header_.version_major = load<std::uint32_t>(bytes.data() + 8);
  header_.version_minor = load<std::uint32_t>(bytes.data() + 12);
  if (header_.version_major != 1) {
    fail("header", "unsupported E57 version", "1.x",
         fmt::format("{}.{}", header_.version_major, header_.version_minor));
  }
  if (const auto page = load<std::uint64_t>(bytes.data() + 40); page != k_e57_page)
    fail("header", "unsupported page size", std::to_string(k_e57_page), std::to_string(page));
  if (file_.size() % k_e57_page != 0) {
    fail("header", "wrong file size", "a multiple of 1024 bytes", std::to_string(file_.size()));
  }
  if (const auto length = load<std::uint64_t>(bytes.data() + 16); length != file_.size()) {
    fail("header", "wrong file size", fmt::format("{} bytes", length), std::to_string(file_.size()));
  }
  header_.xml_length = load<std::uint64_t>(bytes.data() + 32);
  const auto xml_offset = load<std::uint64_t>(bytes.data() + 24);
  view(0, k_header_bytes);
  header_.xml_offset = offset_of(xml_offset, "header", "the XML");
  if (header_.xml_length == 0 || header_.xml_length > size() - header_.xml_offset) {
    fail("header", "the XML exceeds the file", fmt::format("1 to {} bytes", size() - header_.xml_offset),
         std::to_string(header_.xml_length));
  }
}

std::uint64_t E57Pages::offset_of(std::uint64_t physical, const std::string& where,
                                  const std::string& what) const {
  if (physical >= file_.size()) {
    fail(where, "invalid offset of " + what, fmt::format("less than {}", file_.size()),
         std::to_string(physical));
  }
  if (physical % k_e57_page >= k_e57_payload)
    fail(where, "invalid offset of " + what, "an offset outside checksums", std::to_string(physical));
  return physical / k_e57_page * k_e57_payload + physical % k_e57_page;
}

std::span<const std::byte> E57Pages::view(std::uint64_t offset, std::size_t count) {
  if (offset > size() || count > size() - offset) {
    fail(fmt::format("page {}", offset / k_e57_payload), "truncated file",
         fmt::format("{} more bytes", count), std::to_string(size() - std::min(offset, size())));
  }
  if (count == 0) return {};
  const std::uint64_t window_offset = window_page_ * k_e57_payload;
  if (offset < window_offset || offset + count > window_offset + window_.size()) {
    const std::uint64_t first = offset / k_e57_payload;
    const std::uint64_t needed = (offset + count - 1) / k_e57_payload - first + 1;
    const std::uint64_t left = file_.size() / k_e57_page - first;
    fill(first, std::min(std::max(needed, k_window_pages), left));
  }
  return std::span(window_).subspan(static_cast<std::size_t>(offset - window_page_ * k_e57_payload), count);
}

void E57Pages::visit(std::uint64_t offset, std::uint64_t count,
                     const std::function<void(std::span<const std::byte>)>& take) {
  constexpr std::uint64_t k_piece = 1 << 18;
  for (std::uint64_t done = 0; done < count;) {
    const std::uint64_t next = std::min(count - done, k_piece);
    take(view(offset + done, static_cast<std::size_t>(next)));
    done += next;
  }
}

/// Makes the window begin with a page; keeps those of the `page_count` pages that it already has.
void E57Pages::fill(std::uint64_t first_page, std::uint64_t page_count) {
  const std::uint64_t behind = window_page_ + window_.size() / k_e57_payload;
  const bool overlaps = first_page >= window_page_ && first_page < behind;
  const std::uint64_t used = overlaps ? (first_page - window_page_) * k_e57_payload : window_.size();
  window_.erase(window_.begin(), window_.begin() + static_cast<std::ptrdiff_t>(used));
  window_page_ = first_page;
  window_.reserve(static_cast<std::size_t>(page_count * k_e57_payload));
  const std::uint64_t kept = window_.size() / k_e57_payload;
  const auto bytes = file_.view((first_page + kept) * k_e57_page,
                                static_cast<std::size_t>((page_count - kept) * k_e57_page));
  for (std::uint64_t page = kept; page < page_count; ++page) {
    const auto whole = bytes.subspan(static_cast<std::size_t>((page - kept) * k_e57_page), k_e57_page);
    const auto payload = whole.first(k_e57_payload);
    const auto stored = load<std::uint32_t>(whole.data() + k_e57_payload, std::endian::big);
    if (const std::uint32_t sum = crc32c(payload); sum != stored) {
      fail(fmt::format("page {}", first_page + page), "corrupt page: wrong checksum",
           fmt::format("{:08x}", stored), fmt::format("{:08x}", sum));
    }
    window_.insert(window_.end(), payload.begin(), payload.end());
  }
}

void E57Pages::rest() {
  file_.rest();
  window_ = std::vector<std::byte>();
}

void E57Pages::fail(std::string where, std::string problem, std::string expected, std::string found) const {
  throw Error(file_.name(), std::move(where), std::move(problem), std::move(expected), std::move(found));
}

int E57Field::bits() const {
  switch (kind) {
    case E57FieldKind::float32:
      return 32;
    case E57FieldKind::float64:
      return 64;
    case E57FieldKind::text:
      return 8;
    default:
      return std::bit_width(static_cast<std::uint64_t>(maximum) - static_cast<std::uint64_t>(minimum));
  }
}

const char* name_of(E57Projection projection) {
  constexpr const char* k_names[] = {"visual reference", "pinhole", "spherical", "cylindrical"};
  return k_names[static_cast<int>(projection)];
}

E57File::E57File(InputFile file) : pages_(std::move(file)), document_(read_document(pages_)) {}

}  // namespace alidade
