// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <numbers>
#include <string_view>

#include "base/bytes.h"
#include "cloud/e57/e57_xml.h"

namespace alidade {
namespace {

constexpr std::uint64_t k_blob_header_bytes = 16;

E57Blob read_blob_place(const E57Node& node, E57Pages& pages) {
  const std::uint64_t length = node.require_count_attribute("length");
  const std::uint64_t begin =
      pages.place_of(node.require_count_attribute("fileOffset"), node.where(), "the " + node.name());
  const std::uint64_t room = pages.size() - begin;
  if (room < k_blob_header_bytes || length > room - k_blob_header_bytes)
    node.fail("does not fit into the file", fmt::format("at most {} bytes", room), std::to_string(length));
  const std::span<const std::byte> header = pages.view(begin, k_blob_header_bytes);
  const auto id = load<std::uint8_t>(header.data());
  const auto section = load<std::uint64_t>(header.data() + 8);
  if (id != 0) node.fail("has no section where one should begin", "0", std::to_string(id));
  // Writers differ in whether the section's length counts its header.
  if (length > section)
    node.fail("is longer than its section", std::to_string(section), std::to_string(length));
  return {.place = begin + k_blob_header_bytes, .length = length};
}

std::string extension_of(const E57Blob& blob, E57Pages& pages) {
  constexpr std::string_view k_png = "\x89PNG\r\n\x1a\n", k_jpeg = "\xFF\xD8\xFF";
  const std::size_t looked_at =
      blob.length < k_png.size() ? static_cast<std::size_t>(blob.length) : k_png.size();
  const std::span<const std::byte> bytes = pages.view(blob.place, looked_at);
  const std::string_view start(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return start.starts_with(k_png) ? "png" : start.starts_with(k_jpeg) ? "jpg" : "bin";
}

constexpr const char* k_elements[] = {"visualReferenceRepresentation", "pinholeRepresentation",
                                      "sphericalRepresentation", "cylindricalRepresentation"};

std::optional<E57Picture> read_picture(const E57Node& node, E57Projection projection, E57Pages& pages) {
  const E57Node jpeg = node.child("jpegImage"), png = node.child("pngImage");
  if (!jpeg && !png) return std::nullopt;
  E57Picture picture;
  picture.projection = projection;
  picture.blob = read_blob_place(jpeg ? jpeg : png, pages);
  picture.extension = extension_of(picture.blob, pages);
  if (const E57Node mask = node.child("imageMask")) picture.mask = read_blob_place(mask, pages);
  picture.width = node.child("imageWidth").count();
  picture.height = node.child("imageHeight").count();
  picture.focal_length = node.child("focalLength").number_or(0.0);
  picture.pixel_width = node.child("pixelWidth").number_or(0.0);
  picture.pixel_height = node.child("pixelHeight").number_or(0.0);
  picture.principal_x = node.child("principalPointX").number_or(0.0);
  picture.principal_y = node.child("principalPointY").number_or(0.0);
  // One writer misspells the radius.
  picture.radius = node.child("radius").number_or(node.child("readius").number_or(0.0));
  if (projection == E57Projection::spherical && picture.width > 0 && picture.height > 0) {
    // Some writers leave out the pixels of pictures of the whole sphere.
    if (picture.pixel_width == 0.0)
      picture.pixel_width = 2.0 * std::numbers::pi / static_cast<double>(picture.width);
    if (picture.pixel_height == 0.0)
      picture.pixel_height = std::numbers::pi / static_cast<double>(picture.height);
  }
  return picture;
}

}  // namespace

const char* name_of(E57Projection projection) {
  constexpr const char* k_names[] = {"visual reference", "pinhole", "spherical", "cylindrical"};
  return k_names[static_cast<int>(projection)];
}

E57Image read_e57_image(const E57Node& parent, E57Pages& pages, E57Oddities& oddities) {
  E57Image image;
  image.name = parent.child("name").text();
  image.guid = parent.child("guid").text();
  image.scan_guid = parent.child("associatedData3DGuid").text();
  image.pose = read_e57_pose(parent, oddities);
  for (int i = 0; i < 4; ++i) {
    const E57Node node = parent.child(k_elements[i]);
    if (!node) continue;
    const auto picture = read_picture(node, static_cast<E57Projection>(i), pages);
    if (picture) image.pictures.push_back(*picture);
  }
  if (image.pictures.empty()) oddities.add("no picture", parent.where() + " holds no picture");
  return image;
}

}  // namespace alidade
