// SPDX-License-Identifier: MIT
#include "cloud/axis_units.h"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string_view>

#include "base/error.h"

namespace alidade {
namespace {

/// A node such as UNIT["metre",1] or LENGTHUNIT["metre",1] in a piece of WKT.
struct UnitNode {
  std::size_t begin = 0, end = 0;  ///< of the node
  LengthUnit unit;
};

/// The units in a piece of WKT that has no geographic system, as angles also have UNIT in version 1.
std::vector<UnitNode> unit_nodes(std::string_view wkt) {
  constexpr std::string_view k_key = "UNIT[";
  std::vector<UnitNode> nodes;
  // Each character is read once, even if a file nests many of these nodes.
  for (std::size_t at = wkt.find(k_key), end = 0; at != std::string_view::npos; at = wkt.find(k_key, end)) {
    end = at + k_key.size();
    std::size_t begin = at;
    while (begin > 0 && std::isalpha(static_cast<unsigned char>(wkt[begin - 1]))) --begin;
    const std::string_view kind = wkt.substr(begin, at - begin);
    if (!kind.empty() && kind != "LENGTH") continue;
    const std::string_view node = wkt_node(wkt.substr(at), {k_key});
    if (node.empty()) break;
    end = at + node.size();
    const std::size_t quote = node.find('"', k_key.size() + 1);
    if (node[k_key.size()] != '"' || quote == std::string_view::npos) continue;
    const std::size_t digit = node.find_first_of("-0123456789.", quote);
    double metres = 0.0;
    if (digit != std::string_view::npos)
      std::from_chars(node.data() + digit, node.data() + node.size(), metres);
    if (!(metres > 0.0) || !std::isfinite(metres)) continue;
    const std::string name(node.substr(k_key.size() + 1, quote - k_key.size() - 1));
    nodes.push_back({begin, end, {name, metres}});
  }
  return nodes;
}

std::optional<LengthUnit> last_unit(std::string_view wkt) {
  const std::vector<UnitNode> nodes = unit_nodes(wkt);
  if (nodes.empty()) return std::nullopt;
  // Programs have their own names of units: "Foot_US", "Meter".
  LengthUnit unit = nodes.back().unit;
  for (const LengthUnit& known : {k_metre, k_foot, k_survey_foot})
    if (unit == known) unit = known;
  return unit;
}

/// The part of the WKT on heights: a vertical system, or an axis "up" beside two others.
std::string_view vertical_node(std::string_view wkt) {
  const std::string_view vertical = wkt_node(wkt, {"VERT_CS[", "VERTCRS[", "VERTICALCRS["});
  if (!vertical.empty()) return vertical;
  for (std::string_view axis = wkt_node(wkt, {"AXIS["}); !axis.empty(); axis = wkt_node(wkt, {"AXIS["})) {
    if (axis.find("\",up") != axis.npos && axis.find("UNIT[") != axis.npos) return axis;
    wkt.remove_prefix(static_cast<std::size_t>(axis.data() + axis.size() - wkt.data()));
  }
  return {};
}

AxisUnits units_of_wkt(const std::string& wkt) {
  AxisUnits units;
  const std::string_view vertical = vertical_node(wkt);
  units.states_heights = !vertical.empty();
  units.heights = last_unit(vertical);
  std::string_view plane = wkt_node(wkt, {"PROJCS[", "PROJCRS[", "PROJECTEDCRS[", "LOCAL_CS[", "ENGCRS["});
  const std::string_view angles = wkt_node(plane, {"GEOGCS[", "BASEGEOGCRS[", "BASEGEODCRS[", "GEOGCRS["});
  if (!angles.empty())
    plane = plane.substr(static_cast<std::size_t>(angles.data() + angles.size() - plane.data()));
  const std::string_view own_vertical = vertical_node(plane);
  if (!own_vertical.empty())
    plane = plane.substr(0, static_cast<std::size_t>(own_vertical.data() - plane.data()));
  units.plane = last_unit(plane);
  return units;
}

/// Source: OGC GeoTIFF 1.1, 7.4; the codes are those of EPSG.
std::optional<LengthUnit> unit_of_key(const Crs& crs, std::uint16_t key) {
  switch (geotiff_value(crs, key).value_or(0)) {
    case 9001:
      return k_metre;
    case 9002:
      return k_foot;
    case 9003:
      return k_survey_foot;
    default:
      return std::nullopt;
  }
}

constexpr std::uint16_t k_plane_units_key = 3076, k_heights_key = 4096, k_height_units_key = 4099;

/// A WKT without the code of its outermost system.
std::string without_codes(std::string_view wkt) {
  std::string kept;
  int depth = 0;
  bool is_quoted = false;
  for (std::size_t i = 0; i < wkt.size(); ++i) {
    if (wkt[i] == '"') is_quoted = !is_quoted;
    if (!is_quoted && wkt[i] == '[') ++depth;
    if (!is_quoted && wkt[i] == ']') --depth;
    if (!is_quoted && depth == 1 && wkt[i] == ',') {
      const std::string_view next = wkt.substr(std::min(wkt.find_first_not_of(" \t\r\n", i + 1), wkt.size()));
      const bool is_code = next.starts_with("AUTHORITY[") || next.starts_with("ID[");
      const std::string_view code = is_code ? wkt_node(next, {"AUTHORITY[", "ID["}) : std::string_view();
      if (!code.empty()) {
        i = static_cast<std::size_t>(code.data() + code.size() - wkt.data()) - 1;
        continue;
      }
    }
    kept += wkt[i];
  }
  return kept;
}

/// "NAVD88 height (ftUS)" in metres is "NAVD88 height", as EPSG names such systems.
std::string with_unit(std::string name, const LengthUnit& unit) {
  if (name.ends_with(')')) name.resize(std::min(name.rfind(" ("), name.size()));
  if (unit == k_metre) return name;
  return name + (unit == k_survey_foot ? " (ftUS)" : unit == k_foot ? " (ft)" : " (" + unit.name + ")");
}

/// "m", or "ft" for the foot and the US survey foot; empty for others.
std::string label(const std::optional<LengthUnit>& unit) {
  if (unit == k_metre) return "m";
  return unit == k_foot || unit == k_survey_foot ? "ft" : "";
}

}  // namespace

bool LengthUnit::operator==(const LengthUnit& other) const {
  // Programs write the US survey foot with as few digits as 0.3048006; it differs from the foot by 2e-6.
  constexpr double k_last_digits = 1e-7;
  return std::fabs(metres - other.metres) <= k_last_digits * metres;
}

std::string short_name(const LengthUnit& unit) {
  return unit == k_metre ? "m" : unit == k_foot ? "ft" : unit == k_survey_foot ? "us-ft" : unit.name;
}

AxisUnits stated_units(const Crs& crs) {
  if (!crs.wkt.empty()) return units_of_wkt(crs.wkt);
  return {.plane = unit_of_key(crs, k_plane_units_key),
          .heights = unit_of_key(crs, k_height_units_key),
          .states_heights = geotiff_value(crs, k_heights_key).value_or(0) != 0 ||
                            geotiff_value(crs, k_height_units_key).value_or(0) != 0};
}

AxisUnits axis_units(const Crs& crs) {
  const AxisUnits units = stated_units(crs);
  const bool is_complete = units.plane && (units.heights || !units.states_heights);
  return is_complete || !crs.wkt.empty() || crs.empty() ? units : axis_units(crs, whole_wkt(crs));
}

AxisUnits axis_units(const Crs& crs, const std::string& whole_wkt) {
  AxisUnits units = stated_units(crs);
  if (!crs.wkt.empty()) return units;
  const AxisUnits known = units_of_wkt(whole_wkt);
  if (!units.plane) units.plane = known.plane;
  // For a system that the file itself defines, a library can only guess the unit.
  constexpr std::uint16_t k_user_defined = 32767;
  if (!units.heights && geotiff_value(crs, k_heights_key).value_or(k_user_defined) != k_user_defined)
    units.heights = known.heights;
  return units;
}

std::optional<LengthUnit> height_unit(const Crs& crs) {
  const AxisUnits units = axis_units(crs);
  const bool is_metre = !units.of_z() && !units.states_heights && is_geographic(crs);
  return is_metre ? k_metre : units.of_z();
}

std::string plane_unit_label(const Crs& crs) {
  return is_geographic(crs) ? "deg" : label(axis_units(crs).plane);
}

std::string height_unit_label(const Crs& crs) {
  return crs.empty() ? "m" : label(height_unit(crs));
}

Crs with_height_unit(const Crs& crs, const LengthUnit& unit) {
  Crs changed = crs;
  const AxisUnits units = stated_units(crs);
  if (!units.states_heights || units.heights == unit) return changed;
  const std::string wkt = whole_wkt(crs);
  const std::string_view node = vertical_node(wkt);
  if (wkt.empty()) {
    std::vector<std::uint16_t>& keys = changed.geotiff_keys;
    for (std::size_t i = 4; i + 3 < keys.size();) {
      if (keys[i] < k_heights_key || keys[i] > k_height_units_key) {
        i += 4;
        continue;
      }
      keys.erase(keys.begin() + static_cast<std::ptrdiff_t>(i),
                 keys.begin() + static_cast<std::ptrdiff_t>(i + 4));
      --keys[3];
    }
    return changed;
  }
  changed = crs_of_wkt(wkt);
  if (node.empty()) return changed;
  const auto begin = static_cast<std::size_t>(node.data() - wkt.data());
  std::string vertical;
  std::size_t done = 0;
  for (const UnitNode& own : unit_nodes(node)) {
    vertical += node.substr(done, node.find('[', own.begin) - done);
    vertical += fmt::format("[\"{}\",{}]", unit.name, unit.metres);
    done = own.end;
  }
  vertical = without_codes(vertical + std::string(node.substr(done)));
  std::string head = wkt.substr(0, begin);
  const std::size_t quote = vertical.find('"'), end = vertical.find('"', quote + 1);
  if (!vertical.starts_with("AXIS") && end != std::string::npos) {
    const std::string name = vertical.substr(quote + 1, end - quote - 1), renamed = with_unit(name, unit);
    vertical.replace(quote + 1, name.size(), renamed);
    // The name of a compound system ends with it.
    const std::size_t part = name.empty() ? std::string::npos : head.find(name);
    if (part != std::string::npos) head.replace(part, name.size(), renamed);
  }
  changed.wkt = without_codes(head + vertical + wkt.substr(begin + node.size()));
  return changed;
}

std::optional<LengthUnit> height_unit_of_file(const Crs& crs, const AxisUnits& units,
                                              const std::optional<LengthUnit>& stated,
                                              const std::filesystem::path& file) {
  if (stated && units.heights && *units.heights != *stated)
    throw file_error(file, "--vertical-unit contradicts the reference system of the file",
                     units.heights->name + ", or no --vertical-unit", stated->name);
  if (units.states_heights && !units.heights && !stated)
    throw file_error(
        file, "the unit of heights is unknown",
        "--vertical-unit m, ft or us-ft, or a file that 'alidade convert --reproject' wrote with it",
        crs_name(crs));
  return units.heights ? units.heights : stated;
}

HeightChange heights_in_plane_unit(const Crs& crs, const std::optional<LengthUnit>& stated,
                                   const std::filesystem::path& file) {
  HeightChange change{.crs = crs, .note = {}};
  if (!stated && !stated_units(crs).states_heights) return change;
  if (is_geographic(crs) || is_geocentric(crs)) return change;
  const AxisUnits units = axis_units(crs);
  const std::optional<LengthUnit> own = height_unit_of_file(crs, units, stated, file);
  if (!units.plane && *own == k_metre) return change;
  if (!units.plane)
    throw file_error(file, "the unit of x and y is unknown, but heights are in " + own->name,
                     "--crs EPSG:n, which states another system", crs_name(crs));
  if (*own == *units.plane) return change;
  change.factor = own->metres / units.plane->metres;
  change.crs = with_height_unit(crs, *units.plane);
  change.note = fmt::format(
      "heights are converted from {0} to {1}, the unit of x and y; heights in options are in {1}, too",
      own->name, units.plane->name);
  return change;
}

}  // namespace alidade
