// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "cloud/crs.h"
#include "image/film.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"
#include "jobs/visibility/observer_request.h"
#include "jobs/visibility/visibility_cloud.h"
#include "visibility/horizon/horizon.h"
#include "visibility/observers.h"

namespace alidade::jobs {

/// The horizon of one observer, its shares of the sky, and images of what is around it.
struct HorizonRequest : VisibilityRequest {
  ObserverRequest observers;
  double step = 0.5, resolution = 0.01;
  int sky_directions = 4096;
  std::filesystem::path skyline, depth;  ///< empty: none
  ImageSize depth_size{2048, 1024};
};

/// Declares all fields.
void add_horizon_fields(const Fields& fields, HorizonRequest& request);

/// A checked request.
using HorizonPlan = Plan<HorizonRequest>;

/// Checks all that can be checked before a point is read. Errors: no observer; files that cannot be read,
/// replaced or written.
HorizonPlan plan(const HorizonRequest& request);

/// The horizon as it was written.
struct HorizonResult {
  visibility::Observer observer;
  std::vector<visibility::HorizonDirection> line;
  visibility::HorizonFacts facts;
  Crs crs;
  std::optional<image::Film> panorama;  ///< of distances, if the request has a file for it
};

/// Computes the horizon, and writes what the request has a file for. Errors: those of load_cloud_alone(),
/// load_observers() and visibility::horizon(); several observers; a field of view without an azimuth;
/// Cancelled.
HorizonResult run(const HorizonPlan& plan, Listener& listener);

}  // namespace alidade::jobs
