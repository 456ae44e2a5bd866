// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string_view>

namespace alidade {

/// Hertz of "5.8GHz", "868MHz", "2.4": a number with its unit, in any case of letters and with blanks between
/// or not; GHz without one. Empty for anything else and outside of 1 MHz to 1000 GHz.
std::optional<double> parse_frequency(std::string_view text);

}  // namespace alidade
