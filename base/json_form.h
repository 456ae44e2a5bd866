// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "base/color.h"
#include "base/json.h"

// The values of a JSON file, described once: a form reads a value, writes it, and has the JSON Schema of the
// values that it accepts. Forms of structs and lists are made of the forms of their parts.

namespace alidade {

/// A value to be written, whose keys keep their order.
using Json = nlohmann::ordered_json;

/// The form of one kind of value in a file.
template <class Value>
struct JsonForm {
  /// Errors: those of JsonNode.
  std::function<Value(const JsonNode&)> read;
  /// Requires: numbers are finite. Different values have different texts; of a value that a file can have,
  /// read() returns the same one, bit for bit.
  std::function<Json(const Value&)> write;
  Json schema;  ///< draft 2020-12
};

/// The shortest number that is this one again; whole numbers without a point.
Json json_number(double number);
Json json_number(float number);

JsonForm<double> number_form(const NumberRange& range);
/// Three numbers.
JsonForm<glm::dvec3> vector_form(const NumberRange& range);
/// Linear red, green, blue.
JsonForm<Rgb> rgb_form(const NumberRange& range);
JsonForm<bool> boolean_form();
JsonForm<std::string> text_form();

template <class Integer>
JsonForm<Integer> whole_form(std::uint64_t least, std::uint64_t most) {
  return {
      [least, most](const JsonNode& node) { return static_cast<Integer>(node.whole_number(least, most)); },
      [](const Integer& value) { return Json(value); },
      {{"type", "integer"}, {"minimum", least}, {"maximum", most}}};
}

/// One of some values, each with its word.
template <class Value>
JsonForm<Value> word_form(std::vector<std::pair<std::string_view, Value>> words) {
  Json schema{{"enum", Json::array()}};
  std::vector<std::string_view> names;
  for (const auto& [name, value] : words) {
    schema["enum"].push_back(name);
    names.push_back(name);
  }
  return {[words, names](const JsonNode& node) { return words[node.choice(names)].second; },
          [words](const Value& value) {
            return Json(std::ranges::find(words, value, &std::pair<std::string_view, Value>::second)->first);
          },
          std::move(schema)};
}

/// A value, or the word `word` in its place, which reads as an empty optional.
template <class Value>
JsonForm<std::optional<Value>> word_or(std::string_view word, JsonForm<Value> form) {
  return {[word, read = form.read](const JsonNode& node) {
            return node.is_word(word) ? std::nullopt : std::optional(read(node));
          },
          [word, write = form.write](const std::optional<Value>& value) {
            return value ? write(*value) : Json(word);
          },
          {{"oneOf", {{{"const", word}}, form.schema}}}};
}

/// An array of at least so many values, and at most so many if `most` is not 0.
template <class Value>
JsonForm<std::vector<Value>> list_form(JsonForm<Value> form, std::size_t least, std::size_t most = 0) {
  Json schema{{"type", "array"}};
  if (least > 0) schema["minItems"] = least;
  if (most > 0) schema["maxItems"] = most;
  schema["items"] = form.schema;
  return {[read = form.read, least, most](const JsonNode& node) {
            std::vector<Value> all;
            for (const JsonNode& each : node.elements(least, most > 0 ? most : std::size_t(-1)))
              all.push_back(read(each));
            return all;
          },
          [write = form.write](const std::vector<Value>& values) {
            Json all = Json::array();
            for (const Value& value : values) all.push_back(write(value));
            return all;
          },
          std::move(schema)};
}

/// One key of an object, and the member of a Struct that it sets.
template <class Struct>
struct JsonKey {
  std::string name;
  Json schema;  ///< without the default, which is the member's
  std::function<void(const JsonNode&, Struct&)> read;
  /// null: the key is left out.
  std::function<Json(const Struct&)> write;
  bool is_required = false;
  bool has_default = true;  ///< what it means to leave the key out is a value of the key

  JsonKey required() && {
    is_required = true;
    return std::move(*this);
  }
  JsonKey without_default() && {
    has_default = false;
    return std::move(*this);
  }
};

template <class Struct>
using JsonKeys = std::vector<JsonKey<Struct>>;

/// `member`: a pointer to a member, or a function that returns a reference to what the key sets. An optional
/// member may be left out if its form has no word for that; so may a text that is empty.
template <class Struct, class Member, class Value>
JsonKey<Struct> key(std::string name, Member member, JsonForm<Value> form, const std::string& description) {
  Json schema = Json::object();
  if (!description.empty()) schema["description"] = description;
  for (const auto& [word, value] : form.schema.items())
    if (word != "description" || description.empty()) schema[word] = value;
  return {std::move(name), std::move(schema),
          [member, read = form.read](const JsonNode& node, Struct& object) {
            std::invoke(member, object) = read(node);
          },
          [member, write = form.write](const Struct& object) {
            const auto& value = std::invoke(member, object);
            if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::optional<Value>>)
              return value ? write(*value) : Json();
            else
              return write(value);
          }};
}

/// The schema of an object with these keys, whose defaults are the members of `prototype`.
template <class Struct>
Json object_schema(const std::string& description, const JsonKeys<Struct>& keys, const Struct& prototype) {
  Json schema = Json::object();
  if (!description.empty()) schema["description"] = description;
  schema["type"] = "object";
  schema["additionalProperties"] = false;
  Json properties = Json::object();
  for (const JsonKey<Struct>& each : keys) {
    Json& property = properties[each.name] = each.schema;
    if (each.is_required) {
      schema["required"].push_back(each.name);
      continue;
    }
    if (!each.has_default) continue;
    if (Json value = each.write(prototype); !value.is_null() && value != "")
      property["default"] = std::move(value);
  }
  schema["properties"] = std::move(properties);
  return schema;
}

/// Reads the keys of an object. Errors: those of the keys; a key that is not among `known`, a missing one.
template <class Struct>
void read_keys(const JsonNode& node, const JsonKeys<Struct>& keys, const std::vector<std::string_view>& known,
               Struct& object) {
  const JsonFields fields(node, known);
  for (const JsonKey<Struct>& each : keys) {
    if (each.is_required)
      each.read(fields.require(each.name), object);
    else if (const auto found = fields.find(each.name))
      each.read(*found, object);
  }
}

template <class Struct>
std::vector<std::string_view> names_of(const JsonKeys<Struct>& keys) {
  std::vector<std::string_view> names;
  for (const JsonKey<Struct>& each : keys) names.push_back(each.name);
  return names;
}

/// The keys of `object` that are not left out, behind those that `written` has.
template <class Struct>
Json write_keys(const JsonKeys<Struct>& keys, const Struct& object, Json written = Json::object()) {
  for (const JsonKey<Struct>& each : keys)
    if (Json value = each.write(object); !value.is_null() && value != "")
      written[each.name] = std::move(value);
  return written;
}

/// An object; what it does not have is as in `prototype`.
template <class Struct>
JsonForm<Struct> object_form(const std::string& description, JsonKeys<Struct> keys, Struct prototype = {}) {
  Json schema = object_schema(description, keys, prototype);
  const auto shared = std::make_shared<const JsonKeys<Struct>>(std::move(keys));
  return {[shared, prototype](const JsonNode& node) {
            Struct object = prototype;
            read_keys(node, *shared, names_of(*shared), object);
            return object;
          },
          [shared](const Struct& object) { return write_keys(*shared, object); }, std::move(schema)};
}

/// One kind of the objects that a Variant can be.
template <class Variant>
struct JsonKind {
  std::string word;  ///< the value of its key "type"
  std::vector<std::string> names;
  Json schema;
  std::function<Variant(const JsonNode&)> read;
  /// null: it is of another kind.
  std::function<Json(const Variant&)> write;
};

/// A kind that is a Struct.
template <class Variant, class Struct>
JsonKind<Variant> kind(const std::string& word, const std::string& description, JsonKeys<Struct> keys,
                       Struct prototype = {}) {
  Json schema = object_schema(description, keys, prototype);
  Json properties{{"type", {{"const", word}}}}, required{"type"};
  properties.update(schema["properties"]);
  for (const Json& name : schema.value("required", Json::array())) required.push_back(name);
  schema.erase("properties");
  schema["required"] = std::move(required);
  schema["properties"] = std::move(properties);
  const std::vector<std::string_view> views = names_of(keys);
  std::vector<std::string> names{"type"};
  names.insert(names.end(), views.begin(), views.end());
  const auto shared = std::make_shared<const JsonKeys<Struct>>(std::move(keys));
  return {word, names, std::move(schema),
          [shared, names, prototype](const JsonNode& node) {
            Struct object = prototype;
            read_keys(node, *shared, {names.begin(), names.end()}, object);
            return Variant(std::move(object));
          },
          [shared, word](const Variant& value) {
            const Struct* const object = std::get_if<Struct>(&value);
            return object != nullptr ? write_keys(*shared, *object, {{"type", word}}) : Json();
          }};
}

/// An object whose "type" is the word of its kind.
template <class Variant>
JsonForm<Variant> kinds_form(const std::string& description, std::vector<JsonKind<Variant>> kinds) {
  Json schema = Json::object();
  if (!description.empty()) schema["description"] = description;
  for (const JsonKind<Variant>& each : kinds) schema["oneOf"].push_back(each.schema);
  const auto shared = std::make_shared<const std::vector<JsonKind<Variant>>>(std::move(kinds));
  return {[shared](const JsonNode& node) {
            std::vector<std::string_view> words, names;
            for (const JsonKind<Variant>& each : *shared) {
              words.push_back(each.word);
              for (const std::string& name : each.names)
                if (std::ranges::find(names, name) == names.end()) names.push_back(name);
            }
            const auto type = node.find("type");
            const JsonNode word = type ? *type : JsonFields(node, names).require("type");
            return (*shared)[word.choice(words)].read(node);
          },
          [shared](const Variant& value) {
            Json written;
            for (const JsonKind<Variant>& each : *shared)
              if (written.is_null()) written = each.write(value);
            return written;
          },
          std::move(schema)};
}

}  // namespace alidade
