// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "visibility/observers.h"

namespace alidade {

/// Which observers were asked for on the command line.
struct ObserverOptions {
  std::vector<GivenObserver> places;  ///< --observer
  ObserverDefaults defaults;          ///< what holds for those that do not say it themselves
};

/// Declares the options in a group of their own; they fill `options`.
void add_observer_options(CLI::App& command, ObserverOptions& options);

/// --target-height METRES: how far above its cell or point a target is looked at. At least 0.
void add_target_height(CLI::App& command, std::optional<double>& height);

}  // namespace alidade
