// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <bitset>
#include <optional>

#include "visibility/sight_line.h"

namespace alidade {

/// What may block sight, as it was asked for on the command line.
struct OccluderRequest {
  std::optional<OccluderShape> shape;
  std::optional<double> radius;
  int transparency = 1;
  /// Classes whose points block nothing, if the cloud has classes. At first the noise of ASPRS.
  std::bitset<256> ignored_classes = std::bitset<256>{}.set(7).set(18);
};

/// Declares the options in a group of their own; they fill `request`.
void add_occluder_options(CLI::App& command, OccluderRequest& request);

}  // namespace alidade
