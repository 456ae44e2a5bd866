// SPDX-License-Identifier: MIT
#include "cloud/e57/e57_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <numeric>

#include "cloud/e57/e57_xml.h"

namespace alidade {
namespace {

constexpr std::uint64_t k_largest_xml = std::uint64_t{64} << 20;
constexpr std::ptrdiff_t k_most_nodes = 8'000'000;

/// The bytes of the XML without what writers put behind it.
std::string read_xml(E57Pages& pages) {
  const E57Header& header = pages.header();
  if (header.xml_length > k_largest_xml) {
    pages.fail("XML", "is too long", fmt::format("at most {} bytes", k_largest_xml),
               std::to_string(header.xml_length));
  }
  std::string text;
  text.reserve(static_cast<std::size_t>(header.xml_length));
  pages.visit(header.xml_offset, header.xml_length, [&](std::span<const std::byte> bytes) {
    text.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  });
  text.resize(text.find_last_not_of(std::string_view(" \t\r\n\0", 5)) + 1);
  // Every element has a "<", every attribute a "=": this bounds what parsing will take.
  const auto nodes = std::ranges::count(text, '<') + std::ranges::count(text, '=');
  if (nodes > k_most_nodes)
    pages.fail("XML", "has too many elements", fmt::format("at most {}", k_most_nodes),
               std::to_string(nodes));
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
    if (node.type() == pugi::node_doctype) pages.fail("XML", "has a document type", "none");
  }
}

/// Two scans in one function would let a small file claim any number of points.
void check_overlap(const E57Pages& pages, const std::vector<E57Scan>& scans) {
  std::vector<std::size_t> order(scans.size());
  std::iota(order.begin(), order.end(), 0);
  std::erase_if(order, [&](std::size_t i) { return scans[i].record_count == 0; });
  std::ranges::sort(order, {}, [&](std::size_t i) { return scans[i].begin; });
  for (std::size_t i = 1; i < order.size(); ++i) {
    const E57Scan &before = scans[order[i - 1]], &scan = scans[order[i]];
    if (scan.begin >= before.end) continue;
    pages.fail(fmt::format("scan {}", order[i] + 1),
               fmt::format("its section overlaps that of scan {}", order[i - 1] + 1),
               fmt::format("a start at {} or later", before.end), std::to_string(scan.begin));
  }
}

/// Likewise for pictures, which are written to files one by one.
void check_pictures(const E57Pages& pages, const std::vector<E57Image>& images) {
  std::uint64_t left = pages.size();
  for (std::size_t i = 0; i < images.size(); ++i) {
    for (const E57Picture& picture : images[i].pictures) {
      const std::uint64_t length = picture.blob.length + (picture.mask ? picture.mask->length : 0);
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
  check_pictures(pages, document.images);
  return document;
}

}  // namespace

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
