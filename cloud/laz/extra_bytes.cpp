// SPDX-License-Identifier: MIT
#include "cloud/laz/extra_bytes.h"

#include <cassert>
#include <cstring>

namespace alidade {

void ExtraBytesVersion2::start(const std::byte* first) {
  std::memcpy(last_.data(), first, last_.size());
  differences_.reset();
}

BytesVersion1::BytesVersion1(std::size_t count, Written written)
    : written_(written), last_(count), bytes_(8, static_cast<int>(count)) {
  assert(written == Written::all || count == 6);
}

void BytesVersion1::start(const std::byte* first) {
  std::memcpy(last_.data(), first, last_.size());
  changed_.reset();
  bytes_.reset();
}

}  // namespace alidade
