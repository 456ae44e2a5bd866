// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cloud/attributes.h"
#include "cloud/e57/e57_document.h"

namespace alidade {

/// What a field of a scan is read as.
enum class E57Role : std::uint8_t {
  x,
  y,
  z,
  range,
  azimuth,
  elevation,
  cartesian_state,
  spherical_state,
  intensity,
  intensity_invalid,
  red,
  green,
  blue,
  color_invalid,
  row,
  column,
  return_index,
  return_count,
  time,
  time_invalid,
  normal_x,
  normal_y,
  normal_z,
};
inline constexpr std::size_t k_e57_role_count = 23;

/// The field of a scan for each role; empty where it has none. Roles that mean something only together
/// (coordinates, colours, normals) are there together or not at all.
class E57Roles {
 public:
  /// Names are those of the standard; normals those of its extensions, under any prefix. Fields of texts have
  /// no role.
  explicit E57Roles(const E57Scan& scan);

  std::optional<std::size_t> field(E57Role role) const { return fields_[static_cast<std::size_t>(role)]; }
  bool has(E57Role role) const { return field(role).has_value(); }
  bool has_cartesian() const { return has(E57Role::x); }
  bool has_spherical() const { return has(E57Role::range); }

  /// The attributes that these fields fill.
  AttributeSet attributes() const;

  /// The fields that positions need, and those of `attributes`, ascending.
  std::vector<std::size_t> fields_for(AttributeSet attributes) const;

  /// Names of fields without a role.
  const std::vector<std::string>& unread() const { return unread_; }

 private:
  std::array<std::optional<std::size_t>, k_e57_role_count> fields_{};
  std::vector<std::string> unread_;
};

}  // namespace alidade
