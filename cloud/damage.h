// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "base/error.h"

namespace alidade {

/// What a reader does if a file is damaged behind a valid header.
enum class Damage {
  reject,     ///< throws DamagedFile at the first damage
  read_over,  ///< leaves out unreadable points and reports them in FileRead::lost
};

/// Points of a damaged file that cannot be read.
struct LostPoints {
  std::uint64_t count = 0;  ///< 0 = unknown
  std::string location;     ///< as Error's: "byte 36405", "line 17"; may be empty
  std::string problem;      ///< one clause in lower case, without full stop
};

/// The Error for damage that Damage::read_over tolerates. Its message ends with the option for that.
class DamagedFile : public Error {
 public:
  explicit DamagedFile(Parts parts) : Error(with_hint(std::move(parts))) {}

 private:
  static Parts with_hint(Parts parts) {
    std::string& last = !parts.found.empty()      ? parts.found
                        : !parts.expected.empty() ? parts.expected
                                                  : parts.problem;
    // The parts may be those of a DamagedFile that was caught.
    constexpr std::string_view k_hint = "; --partial reads the intact part";
    if (!last.ends_with(k_hint)) last += k_hint;
    return parts;
  }
};

}  // namespace alidade
