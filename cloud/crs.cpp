// SPDX-License-Identifier: MIT

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>

#include "cloud/axis_units.h"
#include "cloud/crs.h"

namespace alidade {

namespace {

/// The numbers of a definition by WKT keyword, for parameters also by name. Equal keywords share a list.
using Definition = std::map<std::string, std::vector<double>>;

/// The numbers behind the name with which `text` begins: "Bessel",6377397.155,299.15],...
std::vector<double> numbers_of(std::string_view text) {
  std::vector<double> numbers;
  std::size_t offset = text.find('"', 1);
  while (offset < text.size() && ++offset < text.size() && text[offset] == ',') {
    offset = std::min(text.find_first_not_of(" \t\r\n", offset + 1), text.size());
    double number = 0;
    const char* const begin = text.data() + offset;
    const auto [end, error] = std::from_chars(begin, text.data() + text.size(), number);
    if (error != std::errc()) break;
    numbers.push_back(number);
    // The loop continues at the comma behind the number.
    offset += static_cast<std::size_t>(end - begin) - 1;
  }
  return numbers;
}

Definition definition_of(std::string_view wkt) {
  Definition definition;
  const std::string_view node = wkt_node(wkt, {"PROJCS["});
  for (const std::string_view word : {"SPHEROID[\"", "PRIMEM[\"", "UNIT[\"", "PARAMETER[\""}) {
    for (std::size_t offset = node.find(word); offset != std::string_view::npos;
         offset = node.find(word, offset + 1)) {
      const std::string_view text = node.substr(offset + word.size() - 1);
      const std::string_view name = text.substr(1, std::min(text.find('"', 1), text.size()) - 1);
      const std::string key = std::string(word) + (word.starts_with("PARAMETER") ? alphanumeric(name) : "");
      std::ranges::copy(numbers_of(text), std::back_inserter(definition[key]));
    }
  }
  return definition;
}

bool has_parameters(const Definition& definition) {
  const auto parameter = definition.lower_bound("PARAMETER");
  return parameter != definition.end() && parameter->first.starts_with("PARAMETER");
}

bool nearly_equal(double a, double b) {
  constexpr double k_last_digits = 1e-9;
  return std::fabs(a - b) <= k_last_digits * std::max(std::fabs(a), std::fabs(b));
}

constexpr std::uint16_t k_model_type = 1024, k_geographic_type = 2048, k_projected_type = 3072,
                        k_vertical_type = 4096;
constexpr std::uint16_t k_geographic_model = 2, k_geocentric_model = 3;

/// The first accepted value of a GeoTIFF key, of those that are stored in the directory itself.
template <class Accepts>
std::optional<std::uint16_t> value_of_key(const Crs& crs, std::uint16_t key, const Accepts& accepts) {
  for (std::size_t i = 4; i + 3 < crs.geotiff_keys.size(); i += 4) {
    const std::uint16_t value = crs.geotiff_keys[i + 3];
    if (crs.geotiff_keys[i] == key && crs.geotiff_keys[i + 1] == 0 && accepts(value)) return value;
  }
  return std::nullopt;
}

bool has_any(const std::string& text, std::initializer_list<std::string_view> words) {
  return std::ranges::any_of(words,
                             [&](std::string_view word) { return text.find(word) != std::string::npos; });
}

/// Whether WKT of version 2 is that of a geodetic system (geographic or geocentric) with such coordinates.
bool is_geodetic(const std::string& wkt, std::string_view coordinates) {
  return (wkt.starts_with("GEODCRS[") || wkt.starts_with("GEODETICCRS[")) &&
         wkt.find(coordinates) != std::string::npos;
}

/// The EPSG code that is the value of this GeoTIFF key; empty if missing.
std::optional<int> code_of_key(const Crs& crs, std::uint16_t key) {
  constexpr std::uint16_t k_user_defined = 32767;
  return value_of_key(crs, key, [](std::uint16_t value) { return value != 0 && value != k_user_defined; });
}

/// Name of the system, which is the first quoted word of a WKT.
std::string wkt_name(const std::string& wkt) {
  const std::size_t begin = wkt.find('"');
  const std::size_t end = begin == std::string::npos ? begin : wkt.find('"', begin + 1);
  return end == std::string::npos ? wkt : wkt.substr(begin + 1, end - begin - 1);
}

/// The code in AUTHORITY["EPSG","25832"] or ID["EPSG",25832] right inside the WKT node that begins at
/// `begin`; empty if missing.
std::optional<int> code_of_node(const std::string& wkt, std::size_t begin) {
  int depth = 0;
  bool is_quoted = false;
  std::size_t word = begin;
  for (std::size_t i = begin; i < wkt.size(); ++i) {
    const char c = wkt[i];
    if (c == '"') is_quoted = !is_quoted;
    if (is_quoted) continue;
    if (c == '[' && ++depth == 2) {
      const std::string_view key = std::string_view(wkt).substr(word, i - word);
      const std::string_view value = std::string_view(wkt).substr(i + 1);
      if ((key == "AUTHORITY" || key == "ID") && value.starts_with("\"EPSG\"")) {
        const std::size_t digits = value.find_first_of("0123456789");
        int code = 0;
        for (std::size_t at = digits;
             at < value.size() && std::isdigit(static_cast<unsigned char>(value[at])) && code < 100000000;
             ++at)
          code = 10 * code + (value[at] - '0');
        if (code > 0) return code;
      }
    }
    if (c == ']' && --depth == 0) return std::nullopt;
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_') word = i + 1;
  }
  return std::nullopt;
}

std::optional<int> code_of_wkt(const std::string& wkt, std::initializer_list<const char*> nodes) {
  for (const char* const node : nodes) {
    const std::size_t begin = wkt.find(node);
    if (begin != std::string::npos) return code_of_node(wkt, begin);
  }
  return std::nullopt;
}

std::optional<int> plane_code(const Crs& crs) {
  if (!crs.wkt.empty())
    return code_of_wkt(crs.wkt, {"PROJCS[", "PROJCRS[", "PROJECTEDCRS[", "GEOGCS[", "GEOGCRS[", "GEODCRS["});
  const std::optional<int> projected = code_of_key(crs, k_projected_type);
  return projected ? projected : code_of_key(crs, k_geographic_type);
}

std::optional<int> vertical_code(const Crs& crs) {
  return crs.wkt.empty() ? code_of_key(crs, k_vertical_type)
                         : code_of_wkt(crs.wkt, {"VERT_CS[", "VERTCRS[", "VERTICALCRS["});
}

CrsLibrary& used_library() {
  static CrsLibrary library;
  return library;
}

}  // namespace

void use_crs_library(const CrsLibrary& library) {
  used_library() = library;
}

const CrsLibrary& crs_library() {
  return used_library();
}

std::string whole_wkt(const Crs& crs) {
  if (!crs.wkt.empty() || crs.empty() || crs_library().wkt == nullptr) return crs.wkt;
  return crs_library().wkt(crs);
}

std::optional<std::uint16_t> geotiff_value(const Crs& crs, std::uint16_t key) {
  return value_of_key(crs, key, [](std::uint16_t) { return true; });
}

bool same_definition(const std::string& wkt_a, const std::string& wkt_b) {
  const Definition a = definition_of(wkt_a), b = definition_of(wkt_b);
  return has_parameters(a) && std::ranges::equal(a, b, [](const auto& one, const auto& other) {
           return one.first == other.first && std::ranges::equal(one.second, other.second, nearly_equal);
         });
}

bool is_geographic(const Crs& crs) {
  // A projected system contains its geographic one, so the projected one decides.
  if (!crs.wkt.empty()) {
    return !has_any(crs.wkt, {"PROJCS[", "PROJCRS[", "PROJECTEDCRS["}) &&
           (has_any(crs.wkt, {"GEOGCS[", "GEOGCRS[", "GEOGRAPHICCRS["}) ||
            is_geodetic(crs.wkt, "CS[ellipsoidal"));
  }
  if (const auto model = geotiff_value(crs, k_model_type)) return *model == k_geographic_model;
  return geotiff_value(crs, k_geographic_type) && !geotiff_value(crs, k_projected_type);
}

bool is_geocentric(const Crs& crs) {
  if (!crs.wkt.empty()) return has_any(crs.wkt, {"GEOCCS["}) || is_geodetic(crs.wkt, "CS[Cartesian,3]");
  return geotiff_value(crs, k_model_type) == k_geocentric_model;
}

std::optional<std::string> implausible_crs(const Crs& crs, const Bounds& bounds) {
  constexpr double k_widest_angle = 400.0, k_least_radius = 6.3e6, k_largest_radius = 6.5e6;
  if (bounds.empty()) return std::nullopt;
  if (is_geocentric(crs)) {
    const double radius = glm::length(bounds.center());
    if (radius >= k_least_radius && radius <= k_largest_radius) return std::nullopt;
    return fmt::format(
        "the coordinate reference system is geocentric, but the points are {:.0f} from its origin, which is "
        "not at the surface of the Earth: they are probably in a projected system",
        radius);
  }
  if (!is_geographic(crs)) return std::nullopt;
  for (int axis = 0; axis < 2; ++axis) {
    for (const double coordinate : {bounds.min[axis], bounds.max[axis]}) {
      if (std::fabs(coordinate) <= k_widest_angle) continue;
      return fmt::format(
          "the coordinate reference system is geographic, but {} {} is not an angle: the points "
          "are probably in a projected system",
          axis == 0 ? "x" : "y", coordinate);
    }
  }
  return std::nullopt;
}

std::vector<std::string> epsg_codes(const Crs& crs) {
  std::vector<std::string> codes;
  for (std::size_t i = 4; i + 3 < crs.geotiff_keys.size(); i += 4) {
    const std::uint16_t key = crs.geotiff_keys[i];
    const std::optional<int> code = code_of_key(crs, key);
    if (!code || *code != crs.geotiff_keys[i + 3]) continue;
    if (key == k_geographic_type || key == k_projected_type) codes.push_back(fmt::format("EPSG:{}", *code));
    if (key == k_vertical_type) codes.push_back(fmt::format("vertical EPSG:{}", *code));
  }
  return codes;
}

std::string alphanumeric(std::string_view name) {
  std::string kept;
  for (const char c : name) {
    const auto character = static_cast<unsigned char>(c);
    if (std::isalnum(character)) kept += static_cast<char>(std::tolower(character));
  }
  return kept;
}

std::string crs_name(const Crs& crs) {
  if (!crs.wkt.empty()) {
    const auto name_of = [&](std::initializer_list<std::string_view> keys) {
      const std::string_view node = wkt_node(crs.wkt, keys);
      return node.empty() ? "" : wkt_name(std::string(node));
    };
    const std::string name = wkt_name(crs.wkt), heights = name_of({"VERT_CS[", "VERTCRS[", "VERTICALCRS["}),
                      plane = name_of({"PROJCS[", "PROJCRS[", "PROJECTEDCRS[", "GEOGCS[", "GEOGCRS["});
    // Programs name a compound system "unknown", or like its first part.
    if (!plane.empty() && !heights.empty()) return plane + " + " + heights;
    const bool is_named = !name.empty() && name != "unknown" && name != "unnamed";
    return is_named ? name : "a system without a name";
  }
  if (crs.geotiff_keys.empty()) return "none";
  const std::vector<std::string> codes = epsg_codes(crs);
  return codes.empty() ? "GeoTIFF keys without EPSG code" : fmt::format("{}", fmt::join(codes, ", "));
}

CrsAgreement compare_crs(const Crs& a, const Crs& b) {
  using enum CrsAgreement;
  if (a == b) return same;
  if (crs_library().compare == nullptr) return compare_crs_text(a, b);
  if (const auto known = crs_library().compare(a, b)) return *known;
  return compare_crs_text(a, b) == same ? same : unknown;
}

CrsAgreement compare_crs_text(const Crs& a, const Crs& b) {
  using enum CrsAgreement;
  if (a == b) return same;
  const AxisUnits units_a = stated_units(a), units_b = stated_units(b);
  const auto differ = [](const std::optional<LengthUnit>& one, const std::optional<LengthUnit>& other) {
    return one && other && *one != *other;
  };
  if (differ(units_a.plane, units_b.plane) || differ(units_a.of_z(), units_b.of_z())) return different;
  const std::optional<int> heights_a = vertical_code(a), heights_b = vertical_code(b);
  if (heights_a && heights_b && heights_a != heights_b) return different;
  const std::optional<int> plane_a = plane_code(a), plane_b = plane_code(b);
  if (plane_a && plane_b) return plane_a == plane_b ? same : different;
  if (!a.wkt.empty() && !b.wkt.empty()) {
    const bool is_same = same_definition(a.wkt, b.wkt);
    // Many systems have the name "unnamed".
    const bool is_known = has_parameters(definition_of(a.wkt)) && has_parameters(definition_of(b.wkt));
    if (alphanumeric(wkt_name(a.wkt)) == alphanumeric(wkt_name(b.wkt)))
      return is_same || !is_known ? same : different;
    return is_same ? unknown : different;
  }
  if (a.wkt.empty() && b.wkt.empty())
    return a.geotiff_keys == b.geotiff_keys && a.geotiff_doubles == b.geotiff_doubles ? same : different;
  return unknown;
}

}  // namespace alidade
