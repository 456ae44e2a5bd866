// SPDX-License-Identifier: MIT
#include "tools/parse_size.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "tools/options.h"

namespace alidade {

std::size_t parse_size(const std::string& text) {
  constexpr std::uint64_t k_most = std::uint64_t{1} << 50;
  const std::string_view units = "kMGT";
  const std::size_t unit = text.empty() ? units.npos : units.find(text.back());
  if (unit == units.npos) return static_cast<std::size_t>(parse_count(text, 1, k_most));
  const double factor = std::pow(1024.0, static_cast<double>(unit + 1));
  const double number =
      parse_number(text.substr(0, text.size() - 1), 0, static_cast<double>(k_most) / factor);
  return static_cast<std::size_t>(std::max(number * factor, 1.0));
}

}  // namespace alidade
