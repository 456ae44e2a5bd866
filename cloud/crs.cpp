// SPDX-License-Identifier: MIT
#include "cloud/crs_name.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string_view>

#include "cloud/same_definition.h"

namespace alidade {
namespace {

constexpr std::uint16_t k_geographic = 2048, k_projected = 3072, k_vertical = 4096;

/// EPSG code that the keys give in place; empty if there is none.
std::optional<int> code_of_key(const Crs& crs, std::uint16_t key) {
  constexpr std::uint16_t k_user_defined = 32767;
  for (std::size_t i = 4; i + 3 < crs.geotiff_keys.size(); i += 4) {
    const std::uint16_t value = crs.geotiff_keys[i + 3];
    const bool stored_in_place = crs.geotiff_keys[i + 1] == 0;
    if (crs.geotiff_keys[i] == key && stored_in_place && value != 0 && value != k_user_defined) return value;
  }
  return std::nullopt;
}

/// Name of the system, which is the first quoted word of a WKT.
std::string wkt_name(const std::string& wkt) {
  const std::size_t begin = wkt.find('"');
  const std::size_t end = begin == std::string::npos ? begin : wkt.find('"', begin + 1);
  return end == std::string::npos ? wkt : wkt.substr(begin + 1, end - begin - 1);
}

/// The code in AUTHORITY["EPSG","25832"] or ID["EPSG",25832] right inside the WKT node that begins at
/// `begin`; empty if there is none.
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
  const std::optional<int> projected = code_of_key(crs, k_projected);
  return projected ? projected : code_of_key(crs, k_geographic);
}

std::optional<int> vertical_code(const Crs& crs) {
  return crs.wkt.empty() ? code_of_key(crs, k_vertical)
                         : code_of_wkt(crs.wkt, {"VERT_CS[", "VERTCRS[", "VERTICALCRS["});
}

}  // namespace

std::vector<std::string> epsg_codes(const Crs& crs) {
  std::vector<std::string> codes;
  for (std::size_t i = 4; i + 3 < crs.geotiff_keys.size(); i += 4) {
    const std::uint16_t key = crs.geotiff_keys[i];
    const std::optional<int> code = code_of_key(crs, key);
    if (!code || *code != crs.geotiff_keys[i + 3]) continue;
    if (key == k_geographic || key == k_projected) codes.push_back(fmt::format("EPSG:{}", *code));
    if (key == k_vertical) codes.push_back(fmt::format("vertical EPSG:{}", *code));
  }
  return codes;
}

std::string letters_and_digits(std::string_view name) {
  std::string kept;
  for (const char c : name) {
    const auto letter = static_cast<unsigned char>(c);
    if (std::isalnum(letter)) kept += static_cast<char>(std::tolower(letter));
  }
  return kept;
}

std::string crs_name(const Crs& crs) {
  if (!crs.wkt.empty()) return wkt_name(crs.wkt);
  if (crs.geotiff_keys.empty()) return "none";
  const std::vector<std::string> codes = epsg_codes(crs);
  return codes.empty() ? "GeoTIFF keys without EPSG code" : fmt::format("{}", fmt::join(codes, ", "));
}

CrsAgreement compare_crs(const Crs& a, const Crs& b) {
  using enum CrsAgreement;
  if (a == b) return same;
  const std::optional<int> heights_a = vertical_code(a), heights_b = vertical_code(b);
  if (heights_a && heights_b && heights_a != heights_b) return different;
  const std::optional<int> plane_a = plane_code(a), plane_b = plane_code(b);
  if (plane_a && plane_b) return plane_a == plane_b ? same : different;
  if (!a.wkt.empty() && !b.wkt.empty()) {
    if (letters_and_digits(wkt_name(a.wkt)) == letters_and_digits(wkt_name(b.wkt))) return same;
    return same_definition(a.wkt, b.wkt) ? unknown : different;
  }
  if (a.wkt.empty() && b.wkt.empty())
    return a.geotiff_keys == b.geotiff_keys && a.geotiff_doubles == b.geotiff_doubles ? same : different;
  return unknown;
}

}  // namespace alidade
