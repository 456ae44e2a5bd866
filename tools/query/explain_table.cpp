// SPDX-License-Identifier: MIT
#include "tools/query/explain_table.h"

#include <fmt/format.h>

namespace alidade {

std::string explain_table(const QueryStatistics& statistics, const TargetKind& kind, std::uint64_t targets,
                          std::uint64_t answers) {
  std::string text = fmt::format("{:<22}{:>16}{:>16}\n", "", "in all", fmt::format("per {}", kind.name));
  const auto row = [&](const char* name, std::uint64_t count) {
    const double mean = targets > 0 ? static_cast<double>(count) / static_cast<double>(targets) : 0.0;
    text += fmt::format("{:<22}{:>16}{:>16.2f}\n", name, count, mean);
  };
  row(std::string(kind.plural).c_str(), targets);
  row("nodes visited", statistics.nodes_visited);
  row("leaves visited", statistics.leaves_visited);
  row("points tested", statistics.points_tested);
  row("pruned by distance", statistics.pruned_by_distance);
  row("pruned by interval", statistics.pruned_by_interval);
  row("pruned by k", statistics.pruned_by_k);
  row("rows answered", answers);
  return text;
}

}  // namespace alidade
