// SPDX-License-Identifier: MIT
#include "octree/cloud/copc/copc_info.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "octree/cloud/byte_order.h"
#include "octree/error.h"

namespace alidade {

CopcInfo parse_copc_info(std::span<const std::byte> data, const std::string& file_name, std::uint64_t place) {
  const auto require = [&](bool holds, std::size_t byte, std::string problem, std::string expected,
                           std::string found) {
    if (holds) return;
    throw Error({.file = file_name,
                 .place = fmt::format("byte {}", place + byte),
                 .problem = std::move(problem),
                 .expected = std::move(expected),
                 .found = std::move(found)});
  };
  constexpr std::size_t k_size = 160;
  require(data.size() == k_size, 0, "bad size of the COPC record", fmt::format("{} bytes", k_size),
          std::to_string(data.size()));
  CopcInfo info;
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t byte = 8 * static_cast<std::size_t>(axis);
    info.centre[axis] = load<double>(data.data() + byte);
    require(std::isfinite(info.centre[axis]), byte, "bad centre of the COPC octree", "a finite number",
            fmt::format("{}", info.centre[axis]));
  }
  info.half_size = load<double>(data.data() + 24);
  info.spacing = load<double>(data.data() + 32);
  require(std::isfinite(info.half_size) && info.half_size > 0, 24, "bad size of the COPC octree",
          "a positive number", fmt::format("{}", info.half_size));
  require(std::isfinite(info.spacing) && info.spacing > 0, 32, "bad spacing of the COPC octree",
          "a positive number", fmt::format("{}", info.spacing));
  info.root_page = load<std::uint64_t>(data.data() + 40);
  info.root_page_size = load<std::uint64_t>(data.data() + 48);
  return info;
}

}  // namespace alidade
