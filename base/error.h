// SPDX-License-Identifier: MIT
#pragma once

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

namespace alidade {

/// The name of a file without possible secrets: of a URL without user and password, and without what follows
/// '?' or '#', such as signatures. Any other name as it is.
inline std::string public_name(std::string name) {
  std::size_t begin = name.find("https://");
  if (begin == std::string::npos) begin = name.find("http://");
  if (begin == std::string::npos) return name;
  begin = name.find("//", begin) + 2;
  const std::size_t parameters = name.find_first_of("?#", begin);
  if (parameters != std::string::npos) name.resize(parameters);
  const std::size_t host_end = name.find('/', begin);
  const std::size_t user_end = name.rfind('@', host_end);
  if (user_end != std::string::npos && user_end >= begin) name.erase(begin, user_end + 1 - begin);
  return name;
}

/// The one exception of all libraries for invalid input: files, scenes and requests. Mistakes that a calling
/// program can avoid are asserted instead; "no result" is an empty optional.
///
/// what() reads "FILE[:LOCATION]: PROBLEM; expected EXPECTED, found FOUND" without the empty parts.
class Error : public std::runtime_error {
 public:
  struct Parts {
    /// Path as given by the caller; empty if the error concerns no file. Of a URL, public_name() is kept.
    std::string file{};
    std::string location{};  ///< "byte 227", "line 3", "12:5" (line:column), or empty
    std::string problem{};   ///< one clause in lower case, without full stop
    std::string expected{};  ///< the valid input
    std::string found{};     ///< the actual input
  };

  explicit Error(Parts parts) : std::runtime_error(compose(parts)), parts_(std::move(parts)) {}
  /// From the parts, in their order.
  Error(std::string file, std::string location, std::string problem, std::string expected = {},
        std::string found = {})
      : Error(Parts{std::move(file), std::move(location), std::move(problem), std::move(expected),
                    std::move(found)}) {}

  const Parts& parts() const { return parts_; }

 private:
  static std::string compose(Parts& parts) {
    parts.file = public_name(std::move(parts.file));
    std::string text;
    if (!parts.file.empty()) {
      text += parts.file;
      if (!parts.location.empty()) text += ":" + parts.location;
      text += ": ";
    }
    text += parts.problem;
    if (!parts.expected.empty()) text += "; expected " + parts.expected;
    if (!parts.found.empty()) text += (parts.expected.empty() ? "; found " : ", found ") + parts.found;
    return text;
  }

  Parts parts_;
};

/// Throws the Error about a byte of a file.
[[noreturn]] inline void fail_at_byte(std::string file, std::uint64_t byte, std::string problem,
                                      std::string expected = {}, std::string found = {}) {
  throw Error(std::move(file), "byte " + std::to_string(byte), std::move(problem), std::move(expected),
              std::move(found));
}

/// Throws the Error of a wrong request unless `holds`. The texts are made in any case: functions that run per
/// target throw input_error() behind an `if`.
inline void check_that(bool holds, std::string problem, std::string expected = {}, std::string found = {}) {
  if (holds) return;
  throw Error({.problem = std::move(problem), .expected = std::move(expected), .found = std::move(found)});
}

/// The error of a file as a whole, or of its name.
inline Error file_error(std::string file, std::string problem, std::string expected = {},
                        std::string found = {}) {
  return {std::move(file), {}, std::move(problem), std::move(expected), std::move(found)};
}

/// The error of an input that has no file, or whose reader adds file and location.
inline Error input_error(std::string problem, std::string expected, std::string found = {}) {
  return {{}, {}, std::move(problem), std::move(expected), std::move(found)};
}

/// The error of a system call that failed, "FILE: PROBLEM: REASON", with the reason of `number`.
inline Error system_error(std::string file, const std::string& problem, int number = errno) {
  return Error(
      {.file = std::move(file), .problem = problem + ": " + std::generic_category().message(number)});
}

/// Returns work(). An Error of it without a file gets this one.
template <class Work>
auto with_file(const std::string& file, const Work& work) -> decltype(work()) {
  try {
    return work();
  } catch (const Error& error) {
    Error::Parts parts = error.parts();
    if (!parts.file.empty()) throw;
    parts.file = file;
    throw Error(std::move(parts));
  }
}

/// Thrown out of a long task whose Progress callback returned false (base/progress.h).
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("cancelled") {}
};

}  // namespace alidade
