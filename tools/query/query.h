// SPDX-License-Identifier: MIT
#pragma once

#include <bitset>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "octree/query.h"
#include "tools/console.h"
#include "tools/options.h"
#include "tools/query/answers.h"
#include "tools/query/line_source.h"

namespace alidade::tools {

/// How targets of one family were given: by the name of a text, or one by one.
struct GivenTargets {
  std::string text;  ///< "-" is standard input; empty if none was given
  std::vector<std::string> values;
};

/// The command line of `alidade query`.
struct QueryCommand : CloudRequest {
  GivenTargets targets[k_target_families];
  TargetFamily family = TargetFamily::rays;  ///< chosen_family()
  std::optional<double> radius, t_min, t_max, entry_min;
  std::optional<std::size_t> k;
  std::optional<Measure> measure;
  std::optional<int> max_level;
  std::optional<std::bitset<256>> classes;
  std::optional<int> precision;  ///< significant digits of numbers in texts
  bool occluded = false, count = false, explain = false;
  bool is_loaded = false;             ///< a COPC file is loaded, not read in place
  std::optional<std::size_t> memory;  ///< bytes to keep of a COPC file that is read in place
  std::filesystem::path output;
  std::optional<AnswerForm> format;
  bool overwrite = false;

  const GivenTargets& given() const { return targets[static_cast<std::size_t>(family)]; }
};

/// The text the targets are in. Errors: LineSource::open().
LineSource open_targets(const QueryCommand& command);

}  // namespace alidade::tools
