// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "base/error.h"

namespace alidade {

/// What a reader does where a file is damaged behind a header that makes sense.
enum class Damage {
  reject,     ///< throws DamagedFile at the first position
  read_over,  ///< leaves out unreadable points and reports them in CloudReader::lost()
};

/// Points that a damaged file does not give any more.
struct LostPoints {
  std::uint64_t count = 0;  ///< 0 = unknown
  std::string location;     ///< as Error's: "byte 36405", "line 17"; may be empty
  std::string problem;      ///< what is wrong, one clause in lower case, without full stop
};

/// Throws the Error about a byte of a file.
[[noreturn]] inline void fail_at_byte(std::string file, std::uint64_t byte, std::string problem,
                                      std::string expected = {}, std::string found = {}) {
  throw Error(std::move(file), "byte " + std::to_string(byte), std::move(problem), std::move(expected),
              std::move(found));
}

/// The Error for damage that Damage::read_over would read over. Its message ends with the option that does
/// so.
class DamagedFile : public Error {
 public:
  explicit DamagedFile(Parts parts) : Error(with_hint(std::move(parts))) {}

 private:
  static Parts with_hint(Parts parts) {
    std::string& last = !parts.found.empty()      ? parts.found
                        : !parts.expected.empty() ? parts.expected
                                                  : parts.problem;
    last += "; --partial reads the intact part";
    return parts;
  }
};

}  // namespace alidade
