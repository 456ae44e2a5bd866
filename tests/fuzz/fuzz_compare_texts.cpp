// SPDX-License-Identifier: MIT
// Any text as thresholds and as a table of pairs: an Error, or thresholds that read the same when written
// again and pairs that name two images.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>

#include "base/error.h"
#include "compare/pair_list.h"
#include "compare/verdict.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  using namespace alidade::image;
  using namespace alidade::compare;
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    for (const Threshold& one : parse_thresholds(text)) {
      const std::string written = to_text(one);
      if (to_text(parse_thresholds(written).at(0)) != written) std::abort();
    }
  } catch (const Error&) {
  }
  try {
    std::istringstream stream(text);
    for (const ImagePair& pair : read_pairs(stream, "pairs.csv"))
      if (pair.reference.empty() || pair.test.empty() || pair.name.empty()) std::abort();
  } catch (const Error&) {
  }
  return 0;
}
