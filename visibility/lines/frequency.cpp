// SPDX-License-Identifier: MIT
#include "visibility/lines/frequency.h"

#include <cctype>
#include <string>

#include "base/text_scanner.h"

namespace alidade {

std::optional<double> parse_frequency(std::string_view text) {
  constexpr double k_least = 1e6, k_most = 1e12;
  const std::size_t end = text.find_last_of("0123456789.");
  if (end == std::string_view::npos) return std::nullopt;
  std::string unit;
  for (const char letter : trim(text.substr(end + 1)))
    unit += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  const double factor = unit.empty() || unit == "ghz" ? 1e9 : unit == "mhz" ? 1e6 : 0.0;
  const std::optional<double> number = parse_number(trim(text.substr(0, end + 1)));
  const double hertz = number.value_or(0.0) * factor;
  return hertz >= k_least && hertz <= k_most ? std::optional(hertz) : std::nullopt;
}

}  // namespace alidade
