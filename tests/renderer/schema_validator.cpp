// SPDX-License-Identifier: MIT
#include "tests/renderer/schema_validator.h"

#include <regex.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <set>
#include <stdexcept>

namespace alidade::test {
namespace {

bool is_type(const Json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "number") return value.is_number();
  if (type == "integer") {
    return value.is_number_integer() ||
           (value.is_number_float() && std::trunc(value.get<double>()) == value.get<double>());
  }
  throw std::logic_error("unsupported type of the field" + type);
}

// long double holds every double and every 64-bit whole number.
long double number(const Json& value) {
  if (value.is_number_unsigned()) return static_cast<long double>(value.get<std::uint64_t>());
  if (value.is_number_integer()) return static_cast<long double>(value.get<std::int64_t>());
  return static_cast<long double>(value.get<double>());
}

// POSIX extended expressions mean the same as ECMAScript's for what the schemas use.
bool matches(const std::string& text, const std::string& pattern) {
  regex_t expression;
  if (::regcomp(&expression, pattern.c_str(), REG_EXTENDED | REG_NOSUB) != 0)
    throw std::logic_error("pattern " + pattern);
  const bool found = ::regexec(&expression, text.c_str(), 0, nullptr, 0) == 0;
  ::regfree(&expression);
  return found;
}

bool has_duplicates(const Json& array) {
  for (std::size_t i = 0; i < array.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (array[i] == array[j]) return true;
    }
  }
  return false;
}

}  // namespace

SchemaValidator::SchemaValidator(const std::filesystem::path& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (!entry.path().string().ends_with(".schema.json")) continue;
    std::ifstream stream(entry.path());
    Json document = Json::parse(stream);
    const std::string id = document.at("$id");
    documents_.emplace(id, std::move(document));
  }
  for (const auto& [id, document] : documents_) {
    const std::function<void(const Json&)> visit = [&, &name = id](const Json& node) {
      if (node.is_object() && node.contains("$ref")) home_.emplace(&node, name);
      if (node.is_structured()) {
        for (const Json& child : node) visit(child);
      }
    };
    visit(document);
  }
}

const Json& SchemaValidator::target(const std::string& reference, const Json& from) const {
  const std::size_t hash = reference.find('#');
  const std::string document = reference.substr(0, hash);
  const Json& root = documents_.at(document.empty() ? home_.at(&from) : document);
  return root.at(Json::json_pointer(reference.substr(hash + 1)));
}

const Json& SchemaValidator::resolved(const Json& schema) const {
  return schema.contains("$ref") ? resolved(target(schema.at("$ref"), schema)) : schema;
}

std::optional<std::vector<SchemaValidator::Applied>> SchemaValidator::validate(const std::string& id,
                                                                               const Json& document) const {
  std::vector<Applied> applied;
  if (!holds(documents_.at(id), document, Json::json_pointer(), applied)) return {};
  return applied;
}

bool SchemaValidator::holds(const Json& schema, const Json& value, const Json::json_pointer& pointer,
                            std::vector<Applied>& applied) const {
  static const std::set<std::string> annotations{"$schema", "$id",         "$defs",
                                                 "title",   "description", "default"};
  applied.push_back({pointer, &schema});
  for (const auto& [keyword, rule] : schema.items()) {
    if (annotations.contains(keyword)) continue;
    if (keyword == "$ref") {
      if (!holds(target(rule, schema), value, pointer, applied)) return false;
    } else if (keyword == "type") {
      if (!is_type(value, rule)) return false;
    } else if (keyword == "const") {
      if (value != rule) return false;
    } else if (keyword == "enum") {
      if (std::find(rule.begin(), rule.end(), value) == rule.end()) return false;
    } else if (keyword == "minimum") {
      if (value.is_number() && number(value) < number(rule)) return false;
    } else if (keyword == "maximum") {
      if (value.is_number() && number(value) > number(rule)) return false;
    } else if (keyword == "exclusiveMinimum") {
      if (value.is_number() && number(value) <= number(rule)) return false;
    } else if (keyword == "exclusiveMaximum") {
      if (value.is_number() && number(value) >= number(rule)) return false;
    } else if (keyword == "minLength") {
      if (value.is_string() && value.get<std::string>().size() < rule.get<std::size_t>()) return false;
    } else if (keyword == "pattern") {
      if (value.is_string() && !matches(value, rule)) return false;
    } else if (keyword == "minItems") {
      if (value.is_array() && value.size() < rule.get<std::size_t>()) return false;
    } else if (keyword == "maxItems") {
      if (value.is_array() && value.size() > rule.get<std::size_t>()) return false;
    } else if (keyword == "uniqueItems") {
      if (value.is_array() && rule == true && has_duplicates(value)) return false;
    } else if (keyword == "items") {
      for (std::size_t i = 0; value.is_array() && i < value.size(); ++i) {
        if (!holds(rule, value[i], pointer / i, applied)) return false;
      }
    } else if (keyword == "properties") {
      for (const auto& [key, property] : rule.items()) {
        if (value.is_object() && value.contains(key) && !holds(property, value[key], pointer / key, applied))
          return false;
      }
    } else if (keyword == "additionalProperties") {
      if (rule != false) throw std::logic_error("additionalProperties other than false");
      if (!value.is_object()) continue;
      for (const auto& [key, member] : value.items()) {
        if (!schema.at("properties").contains(key)) return false;
      }
    } else if (keyword == "required") {
      for (const Json& key : rule) {
        if (value.is_object() && !value.contains(key.get<std::string>())) return false;
      }
    } else if (keyword == "dependentRequired") {
      for (const auto& [key, companions] : rule.items()) {
        if (!value.is_object() || !value.contains(key)) continue;
        for (const Json& companion : companions)
          if (!value.contains(companion.get<std::string>())) return false;
      }
    } else if (keyword == "oneOf") {
      int count = 0;
      for (const Json& alternative : rule) {
        std::vector<Applied> below;
        if (!holds(alternative, value, pointer, below)) continue;
        ++count;
        applied.insert(applied.end(), below.begin(), below.end());
      }
      if (count != 1) return false;
    } else {
      throw std::logic_error("unknown keyword " + keyword);
    }
  }
  return true;
}

}  // namespace alidade::test
