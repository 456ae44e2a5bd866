// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

namespace alidade::tools {

/// What the manual of a command says behind its options: the text of tools/manuals/NAME.txt, which the build
/// puts into the program. `name`: "query", or "visibility_raster" for a command of a group; "alidade" for the
/// program. Requires: there is such a text.
std::string_view manual(std::string_view name);

}  // namespace alidade::tools
