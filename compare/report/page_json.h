// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

// How all JSON of comparisons is made. Keys keep their order.

namespace alidade {

using Json = nlohmann::ordered_json;

/// A number, or the text for what JSON has no number for.
inline Json json_number(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0.0 ? "infinity" : "-infinity";
  return value;
}

/// The document; bytes of names that are no UTF-8 become U+FFFD.
inline std::string json_text(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace alidade
