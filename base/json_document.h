// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace alidade {

struct JsonMember;
struct JsonValue;
using JsonArray = std::vector<JsonValue>;
using JsonObject = std::vector<JsonMember>;

/// One value of a JSON text, with the place where it begins. Whole numbers from 0 to 2^64-1 are kept exactly.
struct JsonValue {
  std::variant<std::nullptr_t, bool, std::uint64_t, double, std::string, JsonArray, JsonObject> data;
  std::size_t begin = 0;  ///< bytes [begin, end) of the text
  std::size_t end = 0;
};

struct JsonMember {
  std::string key;
  std::size_t key_begin = 0;  ///< bytes [key_begin, key_end) with both quotes
  std::size_t key_end = 0;
  JsonValue value;
};

/// A JSON text together with what it says, so that messages can quote it and name line and column.
struct JsonDocument {
  std::string name;  ///< the file, as messages call it
  std::string text;
  JsonValue root;

  /// "LINE:COLUMN" of a byte, both from 1, columns counted in characters.
  std::string place(std::size_t byte) const;
  /// What stands at bytes [begin, end), shortened to one line of at most 40 characters.
  std::string quote(std::size_t begin, std::size_t end) const;
};

/// Parses strict JSON (RFC 8259: UTF-8, no comments, no trailing commas), nested at most 64 deep.
/// What stands under a key of `unread`, at any depth, is checked but not kept: it becomes null. Errors: Error
/// with line and column, for anything else, for a number beyond double, and for a key that stands twice in
/// one object. Cost: linear; memory at most about 100 times the text that is kept.
JsonDocument parse_json(std::string text, std::string name, std::span<const std::string_view> unread = {});

}  // namespace alidade
