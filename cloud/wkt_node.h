// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <initializer_list>
#include <string_view>

namespace alidade {

/// The piece of a WKT from the first of the keys that is in it, such as "PROJCS[", to the bracket that closes
/// it; brackets within quotes do not count. Empty if there is none or it does not end. It points into `wkt`.
inline std::string_view wkt_node(std::string_view wkt, std::initializer_list<std::string_view> keys) {
  for (const std::string_view key : keys) {
    const std::size_t begin = wkt.find(key);
    if (begin == std::string_view::npos) continue;
    int depth = 0;
    bool is_quoted = false;
    for (std::size_t i = begin; i < wkt.size(); ++i) {
      if (wkt[i] == '"') is_quoted = !is_quoted;
      if (is_quoted) continue;
      if (wkt[i] == '[') ++depth;
      if (wkt[i] == ']' && --depth == 0) return wkt.substr(begin, i + 1 - begin);
    }
  }
  return {};
}

}  // namespace alidade
