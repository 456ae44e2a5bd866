// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <utility>

#include "base/error.h"

namespace alidade {

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

}  // namespace alidade
