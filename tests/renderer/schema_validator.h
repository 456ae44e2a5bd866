// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace alidade::test {

using Json = nlohmann::json;

/// A validator for the part of JSON Schema (draft 2020-12) that scenes/schema uses. A keyword it does not
/// know is a std::logic_error, so that no rule of a schema goes unchecked.
class SchemaValidator {
 public:
  /// Loads all *.schema.json of a folder, known by their "$id".
  explicit SchemaValidator(const std::filesystem::path& folder);

  /// A schema that holds for a value of a valid document.
  struct Applied {
    Json::json_pointer pointer;
    const Json* schema;
  };

  /// All schemas that hold for the parts of the document; empty if it is not valid.
  std::optional<std::vector<Applied>> validate(const std::string& id, const Json& document) const;

  const Json& schema(const std::string& id) const { return documents_.at(id); }
  /// Follows "$ref"; `schema` must be part of a loaded document.
  const Json& resolved(const Json& schema) const;
  const std::map<std::string, Json>& documents() const { return documents_; }

 private:
  bool holds(const Json& schema, const Json& value, const Json::json_pointer& pointer,
             std::vector<Applied>& applied) const;
  const Json& target(const std::string& reference, const Json& from) const;

  std::map<std::string, Json> documents_;
  std::map<const Json*, std::string> home_;  // of every schema with a "$ref": the document that contains it
};

}  // namespace alidade::test
