// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>

namespace alidade {

/// The name of a file without possible secrets: of a URL without user and password, and without what follows
/// '?' or '#', such as signatures. Any other name as it is.
inline std::string public_name(std::string name) {
  std::size_t begin = name.find("https://");
  if (begin == std::string::npos) begin = name.find("http://");
  if (begin == std::string::npos) return name;
  begin = name.find("//", begin) + 2;
  const std::size_t parameters = name.find_first_of("?#", begin);
  if (parameters != std::string::npos) name.resize(parameters);
  const std::size_t host_end = name.find('/', begin);
  const std::size_t user_end = name.rfind('@', host_end);
  if (user_end != std::string::npos && user_end >= begin) name.erase(begin, user_end + 1 - begin);
  return name;
}

}  // namespace alidade
