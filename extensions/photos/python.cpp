// SPDX-License-Identifier: MIT
#include <cstring>

#include "extensions/photos/job.h"
#include "python/answer_columns.h"
#include "python/python_jobs.h"

namespace alidade::extensions {
namespace {

using namespace python;

py::object answer_of_photos(const jobs::PhotosPlan&, const jobs::PhotosResult& result) {
  const visibility::PhotoVisibility& seen = result.seen;
  py::dict columns = columns_of_points(jobs::columns_of(seen), seen.counts.size());
  if (!seen.colors.empty()) {
    py::array_t<std::uint16_t> colors({static_cast<py::ssize_t>(seen.colors.size()), py::ssize_t{3}});
    static_assert(sizeof(Color16) == 3 * sizeof(std::uint16_t));
    std::memcpy(colors.mutable_data(), seen.colors.data(), seen.colors.size() * sizeof(Color16));
    columns["color"] = colors;
  }
  py::dict rows;
  const auto add = [&](const char* name, const auto member) {
    rows[name] = array_of(seen.photos.size(), [&](std::size_t i) { return seen.photos[i].*member; });
  };
  rows["name"] = texts_of(result.cameras.size(),
                          [&](std::size_t i) -> const std::string& { return result.cameras[i].name; });
  add("points", &visibility::PhotoSummary::points);
  add("median_sampling", &visibility::PhotoSummary::median_sampling);
  add("median_distance", &visibility::PhotoSummary::median_distance);
  add("largest_overlap", &visibility::PhotoSummary::largest_overlap);
  return points_of(columns, rows, result.crs);
}

}  // namespace

void add_photos(PythonHooks& hooks) {
  hooks.jobs.push_back(job("visibility photos",
                           "Compute which photos see which points: alidade.Points, with rows of photos.",
                           &jobs::add_photos_fields, answer_of_photos));
}

}  // namespace alidade::extensions
