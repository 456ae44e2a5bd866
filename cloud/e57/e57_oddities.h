// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace alidade {

/// What was read over in a file, as clauses. Hundreds of scans by one program are odd in the same way: of
/// each kind the first is told, and how many more there are.
class E57Oddities {
 public:
  void add(const std::string& kind, const std::string& clause) {
    const auto [place, is_first] = kinds_.try_emplace(kind, Kind{clause});
    if (!is_first) ++place->second.more;
  }

  /// Sorted by kind.
  std::vector<std::string> clauses() const {
    std::vector<std::string> clauses;
    for (const auto& [name, kind] : kinds_) {
      clauses.push_back(kind.more == 0
                            ? kind.first
                            : kind.first + ", and " + std::to_string(kind.more) + " more like this");
    }
    return clauses;
  }

 private:
  struct Kind {
    std::string first;
    std::uint64_t more = 0;
  };
  std::map<std::string, Kind> kinds_;
};

}  // namespace alidade
