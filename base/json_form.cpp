// SPDX-License-Identifier: MIT
#include "base/json_form.h"

#include <fmt/format.h>
#include <cmath>

#include "base/words.h"

namespace alidade {
namespace {

Json range_schema(const NumberRange& range) {
  return {{"type", "number"},
          {range.above_minimum ? "exclusiveMinimum" : "minimum", json_number(range.minimum)},
          {range.below_maximum ? "exclusiveMaximum" : "maximum", json_number(range.maximum)}};
}

template <class Vector>
JsonForm<Vector> triple_form(const NumberRange& range) {
  return {[range](const JsonNode& node) { return Vector(node.vector(range)); },
          [](const Vector& value) {
            return Json{json_number(value.x), json_number(value.y), json_number(value.z)};
          },
          {{"type", "array"}, {"minItems", 3}, {"maxItems", 3}, {"items", range_schema(range)}}};
}

}  // namespace

Json json_number(double number) {
  // Beyond that, whole numbers are not exact. Minus zero is a number of its own.
  constexpr double k_largest_exact = 0x1p53;
  if (std::trunc(number) != number || std::abs(number) > k_largest_exact ||
      (number == 0 && std::signbit(number)))
    return number;
  return static_cast<std::int64_t>(number);
}

Json json_number(float number) {
  return json_number(parse_number(fmt::format("{}", number)).value_or(number));
}

JsonForm<double> number_form(const NumberRange& range) {
  return {[range](const JsonNode& node) { return node.number(range); },
          [](double number) { return json_number(number); }, range_schema(range)};
}

JsonForm<glm::dvec3> vector_form(const NumberRange& range) {
  return triple_form<glm::dvec3>(range);
}

JsonForm<Rgb> rgb_form(const NumberRange& range) {
  return triple_form<Rgb>(range);
}

JsonForm<bool> boolean_form() {
  return {&JsonNode::boolean, [](bool value) { return Json(value); }, {{"type", "boolean"}}};
}

JsonForm<std::string> text_form() {
  return {&JsonNode::text,
          [](const std::string& text) { return Json(text); },
          {{"type", "string"}, {"minLength", 1}}};
}

}  // namespace alidade
