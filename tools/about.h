// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace alidade::tools {

/// What 'alidade --version' prints: the version in its first line, then the instruction set that queries use on
/// this machine, the compiler, and the libraries that are linked, those of the module for images and maps last.
std::string version_text();

}  // namespace alidade::tools
