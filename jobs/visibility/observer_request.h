// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/visibility/visibility_cloud.h"
#include "visibility/observers.h"

namespace alidade::jobs {

/// The observers of a request.
struct ObserverRequest {
  std::vector<visibility::GivenObserver> positions;  ///< --observer
  std::filesystem::path file;                        ///< --observers; empty: none
  std::string reference;                             ///< --observers-crs, as ObserverReference::given
  std::string reference_option = "--observers-crs";  ///< its name in messages
  bool anywhere = false;                             ///< also far outside of the cloud
  std::optional<double> grid;                        ///< --observer-grid, width of its cells
  visibility::ObserverDefaults defaults;             ///< for what an observer's row does not state
};

/// Declares the fields in a group of their own; they fill `request`.
void add_observer_fields(const Fields& fields, ObserverRequest& request);

/// The fields of positions alone: no fields of view, which do not apply to what shines from all sides.
void add_observer_positions(const Fields& fields, ObserverRequest& request);

/// The heading of fields of observers.
inline constexpr const char* k_observer_group = "Observers";

/// --target-height LENGTH: how far above its cell or point a target is examined. At least 0.
void add_target_height(const Fields& fields, std::optional<double>& height);

/// Checks the fields before a cloud is loaded. Errors: no observers are given; their file cannot be opened.
void check_given(const ObserverRequest& request);

/// Reads the observers, in the cloud's reference system, and computes their positions, which
/// say_observer_remarks() notes once occluders are measured. Those that were given come first, then the
/// file's, then the grid's. `ground` gives the height of observers without z; if it is empty, the cloud's
/// ground is computed if needed. Errors: no observers; those of read_observers(), observer_grid(),
/// place_observers() and make_ground().
std::vector<visibility::Observer> load_observers(const ObserverRequest& request, const VisibilityCloud& cloud,
                                                 Listener& listener,
                                                 const visibility::GroundHeight& ground = {});

/// Notes where the observers are, with clearance_of() of visibility/observers.h, and warns about them, of
/// observer_remarks(). Requires measured occluders.
void say_observer_remarks(std::span<const visibility::Observer> observers, const VisibilityCloud& cloud,
                          Listener& listener);

}  // namespace alidade::jobs
