// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace alidade {

/// The one exception of all libraries for input that cannot be used: bad files, bad scenes, impossible
/// requests. Caller mistakes that a program can rule out itself are asserted instead; "no result" is an empty
/// optional.
///
/// what() reads "FILE[:PLACE]: PROBLEM; expected EXPECTED, found FOUND", leaving out what is empty.
class Error : public std::runtime_error {
 public:
  struct Parts {
    std::string file{};      ///< path as the caller gave it; empty if no file is concerned
    std::string place{};     ///< "byte 227", "line 3", "12:5" (line:column), or empty
    std::string problem{};   ///< what is wrong, one clause in lower case, without full stop
    std::string expected{};  ///< what would have been right
    std::string found{};     ///< what was there instead
  };

  explicit Error(Parts parts) : std::runtime_error(compose(parts)), parts_(std::move(parts)) {}
  /// The same of parts in their order, for functions that are given them.
  Error(std::string file, std::string place, std::string problem, std::string expected = {},
        std::string found = {})
      : Error(Parts{std::move(file), std::move(place), std::move(problem), std::move(expected),
                    std::move(found)}) {}

  const Parts& parts() const { return parts_; }

 private:
  static std::string compose(const Parts& parts) {
    std::string text;
    if (!parts.file.empty()) {
      text += parts.file;
      if (!parts.place.empty()) text += ":" + parts.place;
      text += ": ";
    }
    text += parts.problem;
    if (!parts.expected.empty()) text += "; expected " + parts.expected;
    if (!parts.found.empty()) text += (parts.expected.empty() ? "; found " : ", found ") + parts.found;
    return text;
  }

  Parts parts_;
};

/// Thrown out of a long task when its Progress callback asked to stop (base/progress.h).
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("cancelled") {}
};

}  // namespace alidade
