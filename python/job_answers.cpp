// SPDX-License-Identifier: MIT
#include "python/job_answers.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "camera/camera_json.h"
#include "compare/report/comparison_json.h"
#include "python/python_cloud.h"

namespace alidade::python {
namespace {

Cell cell_of(const jobs::SqlValue& value) {
  return std::visit([](const auto& one) { return Cell(one); }, value);
}

py::dict observers_of(std::span<const visibility::Observer> observers) {
  py::dict columns;
  columns["name"] =
      texts_of(observers.size(), [&](std::size_t i) -> const std::string& { return observers[i].name; });
  for (const int axis : {0, 1, 2})
    columns[py::str(std::string(1, "xyz"[axis]))] =
        array_of(observers.size(), [&](std::size_t i) { return observers[i].position[axis]; });
  return columns;
}

/// The name of a file; None for none.
py::object name_of_file(const std::filesystem::path& file) {
  return file.empty() ? py::object(py::none()) : text_of(file.string());
}

/// What --json of a command prints.
py::object object_of_json(const std::string& text) {
  return py::module_::import("json").attr("loads")(text_of(text));
}

/// The name of another column: "x:1" beside a column x, as SQLite names it in a table.
py::str unused_name(const py::dict& columns, const std::string& name) {
  py::str unused = text_of(name);
  for (int i = 1; columns.contains(unused); ++i) unused = text_of(fmt::format("{}:{}", name, i));
  return unused;
}

py::dict texts_of(const jobs::MapMetadata& metadata) {
  py::dict texts;
  for (const auto& [key, text] : metadata) texts[py::str(key)] = text_of(text);
  return texts;
}

/// A map of the values by cell.
template <class Value>
py::object map_of(const geo::RasterGrid& grid, std::span<const Value> values, const Crs& crs, double no_data,
                  const jobs::MapMetadata& metadata) {
  py::array_t<Value> array({py::ssize_t{grid.rows}, py::ssize_t{grid.columns}});
  std::ranges::copy(values, array.mutable_data());
  // In the order of affine.Affine, which rasterio uses.
  const py::tuple transform =
      py::make_tuple(grid.cell_size, 0.0, grid.north_west.x, 0.0, -grid.cell_size, grid.north_west.y);
  return answer_type("Map")(array, transform, object_of(crs), no_data, texts_of(metadata));
}

}  // namespace

py::object answer_of(const jobs::RasterPlan&, const jobs::RasterResult& result) {
  return std::visit(
      [&]<class Value>(const std::vector<Value>& values) {
        return map_of<Value>(result.grid, values, result.crs, result.band.no_data, result.metadata);
      },
      result.band.values);
}

py::object answer_of(const jobs::PointsPlan&, const jobs::PointsResult& result) {
  return points_of(columns_of_points(jobs::columns_of(result.seen), result.seen.counts.size()),
                   observers_of(result.observers), result.crs);
}

py::object answer_of(const jobs::HorizonPlan&, const jobs::HorizonResult& result) {
  py::dict columns;
  const auto add = [&](const char* name, const auto& value) {
    columns[name] = array_of(result.line.size(), [&](std::size_t i) { return value(result.line[i]); });
  };
  const auto add_of_blocker = [&](const char* name, const auto& value) {
    add(name, [&](const visibility::HorizonDirection& one) {
      return one.blocker ? value(*one.blocker) : k_no_number;
    });
  };
  add("azimuth", [](const visibility::HorizonDirection& one) { return one.azimuth; });
  add("elevation",
      [](const visibility::HorizonDirection& one) { return one.elevation.value_or(k_no_number); });
  add_of_blocker("distance", [](const visibility::Blocker& one) { return one.distance; });
  add("point_id", [](const visibility::HorizonDirection& one) -> std::int64_t {
    if (!one.blocker) return -1;
    return one.blocker->is_mesh() ? -2 : static_cast<std::int64_t>(one.blocker->point_id);
  });
  add_of_blocker("x", [](const visibility::Blocker& one) { return one.position.x; });
  add_of_blocker("y", [](const visibility::Blocker& one) { return one.position.y; });
  add_of_blocker("z", [](const visibility::Blocker& one) { return one.position.z; });
  add("unscanned",
      [](const visibility::HorizonDirection& one) { return one.unscanned.value_or(k_no_number); });
  py::dict facts;
  const glm::dvec3& eye = result.facts.eye;
  facts["observer"] = text_of(result.observer.name);
  facts["eye"] = py::make_tuple(eye.x, eye.y, eye.z);
  facts["sky_view"] = result.facts.sky.cosine_weighted;
  facts["sky_share"] = result.facts.sky.solid_angle;
  if (result.facts.above_line) {
    facts["sky_view_above"] = result.facts.above_line->cosine_weighted;
    facts["sky_share_above"] = result.facts.above_line->solid_angle;
  }
  return answer_type("Rows")(columns, object_of(result.crs), facts);
}

py::object answer_of(const jobs::SkyPlan&, const jobs::SkyResult& result) {
  if (const auto* const map = std::get_if<geo::Raster<float>>(&result.views))
    return map_of<float>(map->grid, map->values, result.crs, jobs::k_no_float, result.metadata);
  const auto& views = std::get<std::vector<float>>(result.views);
  return points_of(columns_of_points(jobs::columns_of(views), views.size()), {}, result.crs);
}

py::object answer_of(const jobs::SunPlan& plan, const jobs::SunResult& result) {
  const jobs::SunRequest& request = plan.request();
  if (request.has_observers())
    return rows_of(table_of(request, result).rows, result.crs, texts_of(result.metadata));
  if (!result.grid)
    return points_of(columns_of_points(jobs::columns_of(request, result), result.receivers()), {},
                     result.crs);
  py::dict maps;
  for (jobs::SunBand& band : bands_of(request, result)) {
    for (float& value : band.values.values)
      if (std::isnan(value)) value = static_cast<float>(jobs::k_no_float);
    maps[text_of(band.name)] =
        map_of<float>(band.values.grid, band.values.values, result.crs, jobs::k_no_float, result.metadata);
  }
  return maps;
}

py::object answer_of(const jobs::LinesPlan&, const jobs::LinesResult& result) {
  std::vector<visibility::Row> rows;
  for (std::size_t line = 0; line < result.table.pairs.size(); ++line)
    rows.push_back(visibility::line_row(result.table, line));
  return rows_of(rows, result.cloud->cloud.cloud.crs);
}

py::object answer_of(const jobs::SummaryPlan& plan, const jobs::SummaryResult& result) {
  std::vector<visibility::Row> rows;
  for (std::size_t i = 0; i < result.summaries.size(); ++i)
    rows.push_back(visibility::summary_row(result.summaries[i], result.observers[i],
                                           plan.request().summary.bands, result.classes));
  return rows_of(rows, result.crs);
}

py::object answer_of(const jobs::InfoPlan&, const jobs::InfoResult& result) {
  return object_of_json(info_json(result).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace));
}

py::object answer_of(const jobs::ConvertPlan&, const jobs::ConvertResult& result) {
  return py::dict(py::arg("points") = result.point_count, py::arg("input_points") = result.input_count);
}

py::object answer_of(const jobs::IndexPlan&, const jobs::IndexResult& result) {
  return py::dict(py::arg("points") = result.point_count, py::arg("bytes") = result.bytes,
                  py::arg("octree_bytes") = result.octree_bytes);
}

py::object answer_of(const jobs::CatalogPlan&, const jobs::CatalogResult& result) {
  return py::dict(py::arg("files") = result.files.size());
}

py::object answer_of(const jobs::GeneratePlan& plan, PointCloud& result) {
  if (!plan.request().output.empty()) return py::none();
  auto data = std::make_shared<CloudData>();
  data->name = "the courtyard";
  data->points.cloud = std::move(result);
  return py::cast(Cloud(std::move(data)));
}

py::object answer_of(const jobs::ComparePlan& plan, const jobs::CompareResult& result) {
  const compare::PairOutcome& pair = result.front();
  const std::string text = plan.request().is_batch
                               ? compare::batch_json(result)
                               : compare::comparison_json(*pair.comparison, pair.verdict, pair.warnings);
  return object_of_json(text);
}

py::object answer_of(const jobs::LoadPlan&, const database::StoredFiles& result) {
  return py::dict(py::arg("points") = result.point_count);
}

py::object answer_of(const jobs::RewritePlan&, const std::vector<database::RewrittenStatement>& result) {
  py::list statements;
  for (const database::RewrittenStatement& one : result)
    statements.append(py::dict(py::arg("text") = text_of(one.text), py::arg("reason") = text_of(one.reason),
                               py::arg("boxes") = one.box_count, py::arg("share") = one.share));
  return statements;
}

py::object answer_of(const jobs::SqlPlan&, const jobs::SqlResult& result) {
  py::list statements;
  for (const jobs::StatementResult& one : result) {
    py::dict columns;
    for (std::size_t i = 0; i < one.columns.size(); ++i)
      columns[unused_name(columns, one.columns[i])] =
          column_of(one.values[i].size(), [&](std::size_t row) { return cell_of(one.values[i][row]); });
    statements.append(answer_type("Rows")(columns, py::none(), py::dict()));
  }
  return statements.size() == 1 ? py::object(statements[0]) : statements;
}

py::object answer_of(const jobs::QueryPlan& plan, const jobs::QueryResult& result) {
  py::dict columns, facts;
  const auto add = [&](const std::string& name, const auto& value) {
    columns[text_of(name)] =
        array_of(result.rows.size(), [&](std::size_t i) { return value(result.rows[i]); });
  };
  if (plan.request().output.empty())
    for (const jobs::AnswerColumn& column : result.columns) {
      if (column.whole)
        add(column.name,
            [&](const jobs::AnswerRow& row) { return static_cast<std::int64_t>(row.*column.whole); });
      else
        add(column.name, [&](const jobs::AnswerRow& row) {
          return column.real ? row.*column.real : row.position[column.axis];
        });
    }
  for (const jobs::WorkCount& one : result.work) facts[text_of(one.name)] = one.count;
  return answer_type("Rows")(columns, object_of(result.crs), facts);
}

py::object answer_of(const jobs::RenderPlan&, const jobs::RenderResult& result) {
  py::list images, files;
  for (const jobs::RenderedImage& image : result.images) {
    const renderer::RenderStatistics& reached = image.statistics;
    py::dict statistics(py::arg("rays") = reached.ray_count, py::arg("seconds") = reached.seconds,
                        py::arg("least_samples") = reached.least_samples,
                        py::arg("mean_samples") = reached.mean_samples,
                        py::arg("most_samples") = reached.most_samples);
    if (reached.noise) {
      statistics["median_noise"] = reached.noise->median;
      statistics["worst_noise"] = reached.noise->worst;
    }
    images.append(answer_type("RenderedImage")(
        arrays_of(image.film, result.output), name_of_file(image.file), text_of(image.view.name),
        object_of_json(camera::camera_json(image.view.camera)), statistics));
  }
  for (const std::filesystem::path& file : result.files) files.append(name_of_file(file));
  py::list empty_views;
  for (const std::string& name : result.empty_views) empty_views.append(text_of(name));
  return answer_type("Rendering")(images, files, object_of(result.crs), empty_views);
}

py::object answer_of(const jobs::MergePlan& plan, const renderer::MergedImage& result) {
  const std::filesystem::path& file = plan.request().output;
  return answer_type("RenderedImage")(
      file.empty() ? arrays_of(result.film, result.output) : py::dict(), name_of_file(file), "", py::none(),
      py::dict(py::arg("parts") = result.parts, py::arg("camera_rays") = result.samples_taken));
}

}  // namespace alidade::python
