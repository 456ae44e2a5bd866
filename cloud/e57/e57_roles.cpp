// SPDX-License-Identifier: MIT
#include "cloud/e57/e57_roles.h"

#include <algorithm>
#include <string_view>

namespace alidade {
namespace {

struct NamedRole {
  std::string_view name;
  std::optional<Attribute> attribute;  ///< empty for what positions need
};

/// In the order of E57Role.
constexpr std::array<NamedRole, k_e57_role_count> k_roles = {{
    {"cartesianX", {}},
    {"cartesianY", {}},
    {"cartesianZ", {}},
    {"sphericalRange", {}},
    {"sphericalAzimuth", {}},
    {"sphericalElevation", {}},
    {"cartesianInvalidState", {}},
    {"sphericalInvalidState", {}},
    {"intensity", Attribute::intensity},
    {"isIntensityInvalid", Attribute::intensity},
    {"colorRed", Attribute::color},
    {"colorGreen", Attribute::color},
    {"colorBlue", Attribute::color},
    {"isColorInvalid", Attribute::color},
    {"rowIndex", Attribute::extra_dimensions},
    {"columnIndex", Attribute::extra_dimensions},
    {"returnIndex", Attribute::returns},
    {"returnCount", Attribute::returns},
    {"timeStamp", Attribute::gps_time},
    {"isTimeStampInvalid", Attribute::gps_time},
    {"normalX", Attribute::normal},
    {"normalY", Attribute::normal},
    {"normalZ", Attribute::normal},
}};

constexpr std::size_t place_of(E57Role role) {
  return static_cast<std::size_t>(role);
}

/// The role of a field by its name; k_e57_role_count for none.
std::size_t role_of(const E57Field& field) {
  constexpr std::size_t k_first_of_extensions = place_of(E57Role::normal_x);
  if (field.kind == E57FieldKind::text) return k_e57_role_count;
  const std::size_t colon = field.name.rfind(':');
  const bool is_extension = colon != std::string::npos;
  const std::string_view name = std::string_view(field.name).substr(is_extension ? colon + 1 : 0);
  for (std::size_t role = is_extension ? k_first_of_extensions : 0; role < k_roles.size(); ++role) {
    if (k_roles[role].name == name) return role;
  }
  return k_e57_role_count;
}

/// Roles of which one without the others means nothing; the last three follow a first one.
constexpr std::array<std::array<E57Role, 3>, 4> k_triples = {
    {{E57Role::x, E57Role::y, E57Role::z},
     {E57Role::range, E57Role::azimuth, E57Role::elevation},
     {E57Role::red, E57Role::green, E57Role::blue},
     {E57Role::normal_x, E57Role::normal_y, E57Role::normal_z}}};

/// Flags and what they speak of.
constexpr std::array<std::array<E57Role, 2>, 5> k_flags = {{{E57Role::cartesian_state, E57Role::x},
                                                            {E57Role::spherical_state, E57Role::range},
                                                            {E57Role::intensity_invalid, E57Role::intensity},
                                                            {E57Role::color_invalid, E57Role::red},
                                                            {E57Role::time_invalid, E57Role::time}}};

}  // namespace

E57Roles::E57Roles(const E57Scan& scan) {
  for (std::size_t i = 0; i < scan.fields.size(); ++i) {
    const std::size_t role = role_of(scan.fields[i]);
    if (role < k_e57_role_count && !fields_[role]) fields_[role] = i;
  }
  for (const auto& triple : k_triples) {
    const bool complete = std::ranges::all_of(triple, [&](E57Role role) { return has(role); });
    for (const E57Role role : triple) {
      if (!complete) fields_[place_of(role)].reset();
    }
  }
  for (const auto& [flag, subject] : k_flags) {
    if (!has(subject)) fields_[place_of(flag)].reset();
  }
  for (std::size_t i = 0; i < scan.fields.size(); ++i) {
    if (std::ranges::find(fields_, std::optional(i)) == fields_.end()) unread_.push_back(scan.fields[i].name);
  }
}

AttributeSet E57Roles::attributes() const {
  AttributeSet set;
  for (std::size_t role = 0; role < k_roles.size(); ++role) {
    if (fields_[role] && k_roles[role].attribute) set = set | *k_roles[role].attribute;
  }
  return set;
}

std::vector<std::size_t> E57Roles::fields_for(AttributeSet attributes) const {
  std::vector<std::size_t> fields;
  for (std::size_t role = 0; role < k_roles.size(); ++role) {
    const auto& attribute = k_roles[role].attribute;
    if (fields_[role] && (!attribute || attributes.contains(*attribute))) fields.push_back(*fields_[role]);
  }
  std::ranges::sort(fields);
  return fields;
}

}  // namespace alidade
