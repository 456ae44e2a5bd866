// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

namespace alidade::bench {

/// Point data records of an aerial scan over rolling ground with trees, in the order they would be recorded:
/// lines across the flight, up to three returns of a pulse. Formats 0 to 3, 6 and 7. The same on every run.
std::vector<std::byte> scan_records(int point_format, std::size_t count);

}  // namespace alidade::bench
