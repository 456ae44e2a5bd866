// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string_view>

namespace alidade {

/// Bytes of the letter that a text begins with: UTF-8 in its shortest form, without halves of UTF-16 and NUL.
/// 0 if it begins with none.
std::size_t utf8_letter_size(std::string_view text);

/// Whether a text is made of such letters.
bool is_utf8(std::string_view text);

}  // namespace alidade
