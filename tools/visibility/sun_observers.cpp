// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/words.h"
#include "geo/map_unit.h"
#include "tools/command.h"
#include "tools/image_module.h"
#include "tools/visibility/row_output.h"
#include "tools/visibility/sun.h"
#include "visibility/horizon/skyline.h"

namespace alidade::tools {
namespace {

/// Errors that need no cloud.
void check_options(const SunCommand& command) {
  const auto reject = [](const std::string& option) {
    throw input_error(option + " does not apply to --observer", "a map (.tif) or points (.las, .laz, .ply)");
  };
  if (const std::string option = given_map_option(command.map); !option.empty()) reject(option);
  if (command.receiver == visibility::SkyReceiver::surface)
    throw input_error("--receiver surface does not apply to --observer", "--tilt and --aspect");
  if (!command.checkpoint.file.empty()) reject("--checkpoint");
  load_row_writer(command.output);
  if (!command.diagram.empty() && !has_extension(command.diagram, {".png"}))
    throw file_error(command.diagram, "unknown output format", "the extension .png");
  const std::filesystem::path outputs[] = {command.output, command.diagram};
  check_outputs(outputs, command.overwrite, command.inputs({command.observers.file, command.weather}));
}

/// A row for each observer and period.
visibility::PositionTable table_of(const SunCommand& command, const SunSky& sun,
                                   std::span<const visibility::Observer> observers,
                                   std::span<const visibility::Radiation> answers) {
  visibility::PositionTable table{.list = "observers", .rows = {}, .positions = {}};
  std::size_t next = 0;
  for (const visibility::Observer& observer : observers) {
    for (const std::string& period : sun.periods) {
      const glm::dvec3& position = observer.position;
      visibility::Row row{
          {"observer", observer.name}, {"x", position.x}, {"y", position.y}, {"z", position.z}};
      if (!period.empty()) row["period"] = period;
      const visibility::Radiation& answer = answers[next++];
      for (const SunQuantity& quantity : sun_quantities(command))
        row[quantity.name] = std::round(1e4 * static_cast<double>(quantity.value(answer))) / 1e4;
      table.rows.push_back(std::move(row));
      table.positions.push_back(position);
    }
  }
  return table;
}

void write_diagram(const SunCommand& command, const VisibilityCloud& cloud, const SunSky& sun,
                   const visibility::Observer& observer) {
  const visibility::Occluders& occluders = *cloud.occluders;
  const visibility::SightEnd eye = visibility::end_near_surface(occluders, observer.position);
  const std::vector<visibility::HorizonDirection> line =
      with_progress("computing the horizon", "azimuths", command.verbosity, [&](const Progress& progress) {
        return visibility::horizon(occluders, eye, {.max_distance = command.max_distance}, progress);
      });
  visibility::SkylineTexts texts{.title = fmt::format("Path of the sun over {}", observer.name),
                                 .note = {},
                                 .unit = geo::height_unit(cloud.cloud.cloud.crs),
                                 .curves = image_module().sun_curves(sun.schedule)};
  const double offset = sun.schedule.longitude / 15.0;
  const auto minutes = static_cast<int>(std::lround(std::fabs(offset) * 60.0));
  texts.note = fmt::format("{:.2f}, {:.2f}, {:.2f}; hours of mean solar time, UTC {}{}:{:02}",
                           observer.position.x, observer.position.y, observer.position.z,
                           offset < 0.0 ? "-" : "+", minutes / 60, minutes % 60);
  double highest = 0.0;
  for (const visibility::SkylineCurve& curve : texts.curves)
    for (const glm::dvec2& position : curve.positions) highest = std::max(highest, position.y);
  constexpr double k_room_of_labels = 5.0;  // degrees
  visibility::DepthStrip strip =
      visibility::strip_around(line, 0.0, 360.0, std::min(highest + k_room_of_labels, 90.0));
  with_progress("drawing the skyline", "lines of sight", command.verbosity, [&](const Progress& progress) {
    visibility::fill_strip(occluders, eye, command.max_distance, strip, progress);
  });
  image_module().write_skyline(strip, line, texts, command.diagram, command.overwrite);
}

}  // namespace

ExitCode run_sun_observers(const SunCommand& command) {
  check_options(command);
  check_given(command.observers);
  const auto cloud = load_cloud_alone(command, Attribute::classification, AcceptedInput::points_or_raster);
  const std::vector<visibility::Observer> observers =
      load_observers(command.observers, *cloud, command.verbosity);
  if (!command.diagram.empty() && observers.size() != 1)
    throw input_error("--diagram requires a single observer", "one observer",
                      std::to_string(observers.size()));
  const std::unique_ptr<SunSky> sun = sun_of(command, *cloud, observers.size());
  say_sun(command, *sun);
  measure_occluders(*cloud, command.occluders, command.verbosity);
  say_observer_remarks(observers, *cloud, command.verbosity);
  std::vector<visibility::SkyTarget> targets;
  for (const visibility::Observer& observer : observers)
    targets.push_back(
        visibility::target_in_open(visibility::end_near_surface(*cloud->occluders, observer.position)));
  std::vector<visibility::Radiation> answers(targets.size() * sun->periods.size());
  visibility::sun_hours(*cloud->occluders, targets, sun->light,
                        command.hours_options(visibility::SkyReceiver::horizontal), answers);
  const visibility::PositionTable table = table_of(command, *sun, observers, answers);
  visibility::Row members = visibility::Row::object();
  for (const auto& [key, text] : sun_metadata(command, *sun)) members[key] = text;
  write_rows(command, cloud->cloud.cloud, [&](auto form, const auto& head, const auto& to_lon_lat) {
    return visibility::write_positions(table, members, form, head, to_lon_lat, command.output,
                                       command.overwrite);
  });
  if (!command.diagram.empty()) write_diagram(command, *cloud, *sun, observers.front());
  say_note(command.verbosity, fmt::format("wrote {} rows to {}", table.rows.size(), command.output.string()));
  return ExitCode::done;
}

}  // namespace alidade::tools
