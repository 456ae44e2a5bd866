// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

#include "visibility/observers.h"

namespace alidade {

/// A number that files can say of an observer.
struct ObserverField {
  std::string_view name;
  std::string_view short_name;  ///< fits the ten letters that Shapefiles have
  std::optional<double> GivenObserver::*value;

  bool is_called(std::string_view word) const { return word == name || word == short_name; }
};

/// All but the place; a name is a text of its own.
constexpr std::array<ObserverField, 7> k_observer_fields{{
    {"z", "z", &GivenObserver::z},
    {"height", "height", &GivenObserver::height},
    {"azimuth_min", "azim_min", &GivenObserver::azimuth_min},
    {"azimuth_max", "azim_max", &GivenObserver::azimuth_max},
    {"elevation_min", "elev_min", &GivenObserver::elevation_min},
    {"elevation_max", "elev_max", &GivenObserver::elevation_max},
    {"max_distance", "max_dist", &GivenObserver::max_distance},
}};

}  // namespace alidade
