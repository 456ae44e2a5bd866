// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <initializer_list>
#include <limits>
#include <optional>
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

/// One value of a JSON text, with its range of bytes there. Whole numbers from 0 to 2^64-1 are kept exactly.
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

/// A JSON text and the values parsed from it, so that messages can quote the text and name line and column.
struct JsonDocument {
  std::string name;  ///< the file, as messages call it
  std::string text;
  JsonValue root;

  /// "LINE:COLUMN" of a byte, both from 1, columns counted in characters.
  std::string line_and_column(std::size_t byte) const;
  /// The text at bytes [begin, end), shortened to one line of at most 40 characters.
  std::string quote(std::size_t begin, std::size_t end) const;
};

/// Parses strict JSON (RFC 8259: UTF-8, no comments, no trailing commas), nested at most 64 deep.
/// The value of a key of `unread`, at any depth, is checked but not kept: it becomes null. Errors: Error with
/// line and column, for anything else, for a number beyond double, and for a duplicate key of an object.
/// Cost: linear; memory at most about 100 times the text that is kept.
JsonDocument parse_json(std::string text, std::string name, std::span<const std::string_view> unread = {});

/// Which numbers are allowed: minimum to maximum, both included by default.
struct NumberRange {
  double minimum = -std::numeric_limits<double>::max();
  double maximum = std::numeric_limits<double>::max();
  bool above_minimum = false;  ///< the minimum itself is not allowed
  bool below_maximum = false;  ///< the maximum itself is not allowed

  bool contains(double value) const;
  std::string describe() const;  ///< "from 0 to 1", "greater than 0 and at most 10"
};

/// Limits of coordinates and lengths: beyond any place on or near Earth, and squares stay far from the limits
/// of double.
inline constexpr double k_largest_length = 1e12;
inline constexpr NumberRange k_coordinate{-k_largest_length, k_largest_length};
inline constexpr NumberRange k_length{0.0, k_largest_length, true};

/// A value of a document with its JSON pointer. A check that fails throws an Error with file, line, column,
/// pointer, what was expected and what was found. Cheap to copy; the document must outlive it.
class JsonNode {
 public:
  explicit JsonNode(const JsonDocument& document) : document_(&document), value_(&document.root) {}

  const JsonValue& value() const { return *value_; }
  const std::string& pointer() const { return pointer_; }
  const std::string& document_name() const { return document_->name; }
  bool is_object() const { return std::holds_alternative<JsonObject>(value_->data); }
  bool is_array() const { return std::holds_alternative<JsonArray>(value_->data); }
  bool is_number() const {
    return std::holds_alternative<double>(value_->data) ||
           std::holds_alternative<std::uint64_t>(value_->data);
  }
  bool is_string() const { return std::holds_alternative<std::string>(value_->data); }
  /// Whether the value is `word` instead of one of another type. Errors: another word.
  bool is_word(std::string_view word) const;

  double number(const NumberRange& range = {}) const;
  /// Whole number, also written as 5.0 or 5e1.
  std::uint64_t whole_number(std::uint64_t minimum, std::uint64_t maximum) const;
  /// Text that is not empty and holds no NUL, as names of files need it.
  std::string text() const;
  /// Index of the word in `words`.
  std::size_t choice(std::span<const std::string_view> words) const;
  /// Elements of an array that must have at least `minimum` and at most `maximum`.
  std::vector<JsonNode> elements(std::size_t minimum, std::size_t maximum) const;
  /// An array of exactly three numbers.
  glm::dvec3 vector(const NumberRange& range) const;

  /// Name and value of every member of an object.
  std::vector<std::pair<std::string, JsonNode>> members() const;
  /// true or false.
  bool boolean() const;

  /// The member of that name, if this is an object and has it.
  std::optional<JsonNode> find(std::string_view key) const;

  /// Throws an Error located at this value; `found` quotes the value unless given.
  [[noreturn]] void fail(const std::string& problem, const std::string& expected,
                         const std::optional<std::string>& found = {}) const;

 private:
  friend class JsonFields;
  JsonNode child(const JsonValue& value, std::string_view step) const;
  std::string describe() const;
  [[noreturn]] void fail_at(std::size_t byte, const std::string& problem, const std::string& expected,
                            const std::string& found, const std::string& pointer) const;

  const JsonDocument* document_;
  const JsonValue* value_;
  std::string pointer_;
};

/// Access to an object with a fixed set of keys: another key is an error that names the nearest of `known`.
class JsonFields {
 public:
  JsonFields(const JsonNode& node, std::span<const std::string_view> known);
  JsonFields(const JsonNode& node, std::initializer_list<std::string_view> known)
      : JsonFields(node, std::span(known.begin(), known.size())) {}

  std::optional<JsonNode> find(std::string_view key) const { return node_.find(key); }
  JsonNode require(std::string_view key) const;

 private:
  JsonNode node_;
};

/// "version" of our own files must be 1.
void read_version(const JsonNode& version);

}  // namespace alidade
