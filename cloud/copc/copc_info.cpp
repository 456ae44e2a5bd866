// SPDX-License-Identifier: MIT
#include "cloud/copc/copc_info.h"

#include <fmt/format.h>

#include <cmath>

#include "base/bytes.h"

namespace alidade {

CopcInfo parse_copc_info(std::span<const std::byte> data, const std::string& file_name, std::uint64_t place) {
  const HeaderFields fields(data, file_name, place);
  constexpr std::size_t k_size = 160;
  fields.require(data.size() == k_size, 0, "bad size of the COPC record", fmt::format("{} bytes", k_size),
                 data.size());
  CopcInfo info;
  info.half_size = fields.get<double>(24);
  // The cube's side is twice as long and must be a number, too.
  fields.require(std::isfinite(2 * info.half_size) && info.half_size > 0, 24, "bad size of the COPC octree",
                 "a positive number", info.half_size);
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t byte = 8 * static_cast<std::size_t>(axis);
    info.centre[axis] = fields.get<double>(byte);
    fields.require(std::isfinite(std::abs(info.centre[axis]) + 2 * info.half_size), byte,
                   "bad centre of the COPC octree", "a finite number", info.centre[axis]);
  }
  info.spacing = fields.get<double>(32);
  fields.require(std::isfinite(info.spacing) && info.spacing > 0, 32, "bad spacing of the COPC octree",
                 "a positive number", info.spacing);
  info.root_page = fields.get<std::uint64_t>(40);
  info.root_page_size = fields.get<std::uint64_t>(48);
  return info;
}

}  // namespace alidade
