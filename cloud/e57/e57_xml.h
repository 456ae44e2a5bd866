// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <pugixml.hpp>
#include <string>

#include "cloud/e57/e57_file.h"

namespace alidade {

/// An element of the XML of an E57 file, with its location for messages. A missing element is a node that is
/// false; its values are empty. Namespaces are ignored, since files with undeclared prefixes are common.
class E57Node {
 public:
  E57Node(const E57Pages& pages, pugi::xml_node element, std::string where)
      : pages_(&pages), element_(element), where_(std::move(where)) {}

  explicit operator bool() const { return static_cast<bool>(element_); }
  const pugi::xml_node& element() const { return element_; }
  /// The location for messages: "XML", "scan 1", "image 2". Children have that of their parent.
  const std::string& where() const { return where_; }
  std::string name() const { return element_.name(); }

  /// The first child of this name.
  E57Node child(const char* name) const { return {*pages_, element_.child(name), where_}; }
  /// A node for an element below this one, with the same location.
  E57Node descend(pugi::xml_node element) const { return {*pages_, element, where_}; }

  /// The text of the element without leading and trailing blanks.
  std::string text() const;
  /// The value of a Float, an Integer or a ScaledInteger, to which scale and offset are applied. Empty
  /// without element or text. Errors: not a finite number.
  std::optional<double> number() const;
  double number_or(double otherwise) const { return number().value_or(otherwise); }
  /// The value of an integer of at least 0; 0 without element or text. Errors: anything else.
  std::uint64_t count() const;

  /// Attributes; empty if missing. Errors: not a number of that kind; a required attribute is missing.
  std::optional<std::int64_t> integer_attribute(const char* name) const;
  std::optional<double> number_attribute(const char* name) const;
  std::uint64_t require_count_attribute(const char* name) const;

  /// Throws an Error about this element.
  [[noreturn]] void fail(std::string problem, std::string expected = {}, std::string found = {}) const;

 private:
  const E57Pages* pages_;
  pugi::xml_node element_;
  std::string where_;
};

/// The pose of a scan or image; empty if it has none. Quaternions are normalized; one whose length differs
/// from 1 by more than 0.001 is added to `oddities`. Errors: length 0, a number that is not finite.
std::optional<E57Pose> read_e57_pose(const E57Node& parent, E57Oddities& oddities);

/// The scan that `parent` describes. Checks that its section lies in the file and can hold the records, not
/// that it is apart from other sections. Errors: missing, invalid or unsupported elements.
E57Scan read_e57_scan(const E57Node& parent, E57Pages& pages, E57Oddities& oddities);

/// The image that `parent` describes; one without a representation is added to `oddities`. Errors: invalid
/// elements, sections outside the file.
E57Image read_e57_image(const E57Node& parent, E57Pages& pages, E57Oddities& oddities);

}  // namespace alidade
