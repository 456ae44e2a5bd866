// SPDX-License-Identifier: MIT
#include "cloud/cloud_reader.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <utility>

#include "base/error.h"
#include "base/text_scanner.h"
#include "cloud/catalog.h"
#include "cloud/input_view.h"
#include "cloud/point_table.h"
#include "cloud/rows.h"

namespace alidade {

std::size_t room_in_piece(PointCloud& cloud, AttributeSet coming, std::uint64_t wanted,
                          const CloudPieces& pieces) {
  if (!pieces.take) return static_cast<std::size_t>(wanted);
  const std::uint64_t bytes = bytes_per_point(cloud, cloud.attributes() | coming) + pieces.bytes_beside;
  const std::uint64_t most = std::clamp<std::uint64_t>(pieces.most_bytes / bytes, 1, UINT32_MAX);
  if (cloud.size() >= most) pieces.take(cloud);
  return static_cast<std::size_t>(std::min(wanted, most - cloud.size()));
}

void RowsToFill::make_rows() {
  const std::size_t count = room_in_piece(cloud_, filled_, left_, pieces_);
  next_ = cloud_.size();
  left_ -= count;
  append_rows(cloud_, filled_, count);
}

std::optional<Bounds> widened_header_box(const Bounds& stated, const Lattice& lattice) {
  constexpr double k_steps = 8, k_share = 1e-5;
  if (stated.empty() || !to_lattice(lattice, stated.min) || !to_lattice(lattice, stated.max))
    return std::nullopt;
  const glm::dvec3 sides = stated.size();
  const double longest = std::max({sides.x, sides.y, sides.z});
  if (longest == 0.0) return std::nullopt;
  const glm::dvec3 margin = glm::max(k_steps * lattice.scale, glm::dvec3(k_share * longest));
  return Bounds{stated.min - margin, stated.max + margin};
}

glm::dvec3 FileFacts::resolution(const Bounds& bounds) const {
  glm::dvec3 result(0.0);
  for (int axis = 0; axis < 3 && !bounds.empty(); ++axis) {
    const double largest = std::max(std::abs(bounds.min[axis]), std::abs(bounds.max[axis]));
    if (const auto type = coordinate_types[static_cast<std::size_t>(axis)])
      result[axis] = type_resolution(*type, largest);
  }
  return result;
}

FileRead CloudReader::read_rows(std::uint64_t taken, std::uint64_t dropped,
                                std::vector<LostPoints> lost) const {
  FileRead done{.files = {facts_.file}, .lost = std::move(lost)};
  done.files.front().point_count = taken;
  done.files.front().dropped_count = dropped;
  return done;
}

std::unique_ptr<CloudReader> open_stored_cloud(const CloudInput& input, Damage damage) {
  constexpr std::size_t k_start_bytes = 4096;
  constexpr const char* k_supported = "LAS, LAZ, PLY, PCD, E57, PTX, PTS, CSV, XYZ or an index file";
  InputFile file = input.file();
  if (input.format != nullptr) {
    const std::vector<std::string> columns = input.view ? input.view->columns : std::vector<std::string>();
    if (columns.empty()) return input.format->open(std::move(file), damage);
    if (input.is(k_text_format)) return open_text(std::move(file), damage, columns);
    throw file_error(file.name(), "--columns requires a text file", "XYZ, CSV or PTS",
                     std::string(input.format->name));
  }
  if (file.size() == 0) throw Error({.file = file.name(), .problem = "empty file", .expected = k_supported});
  const std::span<const std::byte> start = file.view_up_to(0, k_start_bytes);
  reject_utf16({reinterpret_cast<const char*>(start.data()), start.size()}, file.name());
  throw Error(
      {.file = file.name(), .problem = "unknown format", .expected = k_supported, .found = "binary data"});
}

std::unique_ptr<CloudReader> open_cloud(const CloudInput& input, Damage damage) {
  std::unique_ptr<CloudReader> reader = open_stored_cloud(input, damage);
  const FileFacts& facts = reader->facts();
  if (damage == Damage::reject)
    check_stated(input, facts.point_count, facts.box ? facts.file.stated_bounds : std::nullopt);
  if (!input.view) return reader;
  ReferenceChange change = input.view->change_of(input, facts);
  if (!input.is_changed() && change.height_factor == 1.0) return reader;
  return open_view(std::move(reader), input.view, std::move(change), damage);
}

}  // namespace alidade
