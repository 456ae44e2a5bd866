// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "image/point_color.h"

namespace alidade {

/// Name and colour of one class.
struct ClassStyle {
  std::string name;
  Color16 color{0};  ///< display-referred
};

/// All 256 classes: names of LAS 1.4 R15, table 17 (point formats 6 to 10); 8 and 12, reserved there, as in
/// the formats before; "Reserved N" to 63, "User class N" from 64. Colours are the customary ones: ground
/// brown, vegetation from light to dark green, buildings red, water blue, wires yellow. Reserved and user
/// classes have colours of their own; no two of the 256 are equal. `changed` stands above all that.
std::array<ClassStyle, 256> class_styles(std::span<const ClassColor> changed = {});

}  // namespace alidade
