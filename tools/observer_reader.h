// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "geo/vector_file.h"

// What the commands of visibility have the module do for them (tools/load_module.h).

namespace alidade {

/// read_observers() of visibility/read_observers.h, into `observers`. Errors, here and below: those of
/// load_module_function().
using ObserverReader = void (*)(const std::filesystem::path& path, const ObserverReference& reference,
                                std::vector<GivenObserver>& observers);
ObserverReader load_observer_reader();

/// to_cloud_reference() of geo/vector_file.h, for observers that say no system themselves.
using ObserverTransformer = void (*)(const ObserverReference& reference,
                                     std::vector<GivenObserver>& observers);
ObserverTransformer load_observer_transformer();

}  // namespace alidade
