// SPDX-License-Identifier: MIT
// Any bytes as a catalog: an Error, or files that lie in its folder or on the web.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "base/error.h"
#include "cloud/catalog.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    for (const CloudInput& input : parse_catalog(text, "tiles/site.catalog.json")) {
      const std::string name = input.name.lexically_normal().string();
      const bool is_on_web = name.starts_with("http:/") || name.starts_with("https:/");
      if (!is_on_web && !(name.starts_with("tiles/") && name.size() > 6)) std::abort();
      if (input.stated && input.stated->box.empty()) std::abort();
    }
  } catch (const Error&) {
  }
  return 0;
}
