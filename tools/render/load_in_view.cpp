// SPDX-License-Identifier: MIT
#include "tools/render/load_in_view.h"

#include <fmt/format.h>

#include <algorithm>

#include "image/color_points.h"
#include "renderer/cloud_in_view.h"
#include "renderer/load_cloud.h"
#include "tools/cloud/load_cloud.h"
#include "tools/message.h"

namespace alidade {
namespace {

void check(const CloudSettings& settings, const Scene& scene, std::span<const View> views) {
  if (settings.files.size() != 1 || !has_parts(settings.files.front())) {
    throw Error({.file = settings.files.empty() ? "" : settings.files.front().string(),
                 .problem = "--in-view needs one cloud that lies in a database",
                 .expected = "a database that 'alidade sql load' wrote"});
  }
  if (views.empty())
    throw Error({.problem = "--in-view needs a camera that does not go by the cloud",
                 .expected = "--camera, --panorama or a scene file"});
  if (settings.max_level < k_max_level || settings.partial)
    throw Error({.problem = "--in-view cannot be used with --max-level or --partial"});
  if (std::ranges::find(scene.output.layers, Layer::id) != scene.output.layers.end()) {
    throw Error({.problem = "--in-view does not know the ids that points have in the whole cloud",
                 .expected = "layers without id"});
  }
}

/// One filter per view; points further from its half-spaces than their radius are not seen.
std::vector<PointFilter> view_filters(std::span<const View> views, double radius) {
  std::vector<PointFilter> filters;
  for (const View& view : views) {
    PointFilter& filter = filters.emplace_back();
    for (const Plane& plane : view_planes(view.camera).planes)
      filter.planes.push_back({plane, {-radius, std::numeric_limits<double>::infinity()}});
  }
  return filters;
}

}  // namespace

LoadedCloud load_in_view(const RenderCommand& command, const Scene& scene, std::span<const View> views,
                         const Progress& measuring) {
  const CloudSettings& settings = *scene.cloud;
  check(settings, scene, views);
  const Verbosity verbosity = command.verbosity.verbosity();
  const char* const unit = part_unit(settings.files.front());
  ProgressLine line(fmt::format("loading {} in view", unit), unit, verbosity);
  CloudPart part =
      read_database_part(settings.files.front(), view_filters(views, settings.radius.value_or(0.0)),
                         attributes_for(settings.color), line.callback());
  line.finish();
  if (verbosity != Verbosity::quiet && part.chunk_count > 0)
    say_note(fmt::format("read {} of {} chunks of {}", part.chunks_read, part.chunk_count,
                         settings.files.front().string()));
  LoadedCloud loaded = index_cloud(std::move(part.cloud), part.attributes, settings);
  choose_radius(settings, loaded, measuring);
  return loaded;
}

}  // namespace alidade
