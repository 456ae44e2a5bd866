// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/shown_text.h"
#include "jobs/field_table.h"
#include "jobs/visibility/raster.h"
#include "python/python_cloud.h"

namespace alidade::python {
namespace {

/// Keeps what a job says until Python can hear it.
class PythonListener : public jobs::Listener {
 public:
  explicit PythonListener(const Progress& progress, std::vector<std::string>& notes,
                          std::vector<std::string>& warnings)
      : progress_(progress), notes_(notes), warnings_(warnings) {}

  void note(std::string_view text) override { notes_.push_back(line_text(text)); }
  void warn(std::string_view text) override { warnings_.emplace_back(text); }
  void warn_always(std::string_view text) override { warn(text); }
  bool is_listening() const override { return true; }
  bool stops() const override { return is_interrupted(); }
  std::unique_ptr<Stage> begin(std::string, std::string) override {
    return std::make_unique<WatchedStage>(progress_);
  }

 private:
  struct WatchedStage : Stage {
    explicit WatchedStage(const Progress& progress) : watch(progress) {}
    Progress callback() override { return watch; }
    void skip(std::uint64_t) override {}
    void finish() override {}
    const Progress& watch;
  };

  const Progress& progress_;
  std::vector<std::string>&notes_, &warnings_;
};

/// A number or text as a field reads it.
std::string word_of(const py::handle& value) {
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (py::hasattr(value, "__fspath__")) return value.attr("__fspath__")().cast<std::string>();
  // The shortest text that is this number again; NumPy's own names its type.
  if (py::hasattr(value, "__index__")) return py::str(value.attr("__index__")());
  if (py::hasattr(value, "__float__")) return py::repr(value.attr("__float__")());
  return py::str(value);
}

bool is_list(const py::handle& value) {
  return !py::isinstance<py::str>(value) && !py::isinstance<py::bytes>(value) &&
         !py::hasattr(value, "__fspath__") && py::hasattr(value, "__len__");
}

/// "1.0,2.5" of (1.0, 2.5).
std::string text_of_value(const py::handle& value) {
  if (!is_list(value)) return word_of(value);
  std::string text;
  for (const py::handle& one : value) text += (text.empty() ? "" : ",") + word_of(one);
  return text;
}

/// The texts of a field that takes many: one for each item; a single position is one item.
std::vector<std::string> texts_of_values(const py::handle& value) {
  std::vector<std::string> texts;
  const bool has_items = is_list(value) && py::len(value) > 0 &&
                         (is_list(value[py::int_(0)]) || py::isinstance<py::str>(value[py::int_(0)]) ||
                          py::hasattr(value[py::int_(0)], "__fspath__"));
  if (!has_items) return {text_of_value(value)};
  for (const py::handle& one : value) texts.push_back(text_of_value(one));
  return texts;
}

/// Gives a field a value of Python. None and False leave it as it is.
void give(jobs::FieldTable& table, const std::string& name, const py::handle& value) {
  if (value.is_none() || value.is(py::handle(Py_False))) return;
  if (value.is(py::handle(Py_True))) return table.give(name, {});
  const bool is_many = std::ranges::any_of(table.entries(), [&](const jobs::FieldEntry& field) {
    std::string plain = name;
    std::ranges::replace(plain, '_', '-');
    return (field.form == jobs::FieldForm::repeated || field.form == jobs::FieldForm::words) &&
           std::ranges::count(jobs::plain_names(field), plain) > 0;
  });
  table.give(name, is_many ? texts_of_values(value) : std::vector{text_of_value(value)});
}

/// Outputs beside the map itself.
constexpr std::array<std::string_view, 1> k_silent_fields = {"preview"};

/// Plans and runs a job on files with these fields. `note` is called with what the job notes.
template <class Request>
auto run_job(const char* command, void (*add_fields)(const jobs::Fields&, Request&), const FileNames& files,
             int workers, const py::object& progress, const py::object& note, const py::kwargs& fields) {
  Request request;
  const auto table = std::make_shared<jobs::FieldTable>(command, &is_interrupted);
  add_fields(jobs::Fields(table), request);
  std::vector<std::string> notes, warnings;
  using Result = decltype(run(plan(request), std::declval<jobs::Listener&>()));
  std::optional<Result> result;
  // Also after an error: what was said before may explain it.
  const auto tell = [&] {
    if (!note.is_none())
      for (const std::string& text : notes) note(text_of(text));
    warn(warnings);
  };
  try {
    table->waive("output");
    for (const auto& [name, value] : fields) give(*table, py::str(name), value);
    std::vector<std::string> names;
    for (const std::filesystem::path& file : names_of(files)) names.push_back(file.string());
    table->give("cloud", std::move(names));
    request.command = jobs::command_text(*table, k_silent_fields);
    run_watched(workers, progress, [&](const Progress& watch) {
      table->read();
      PythonListener listener(watch, notes, warnings);
      result.emplace(run(plan(request), listener));
    });
  } catch (const jobs::UsageError& error) {
    throw Error({.problem = error.what()});
  } catch (...) {
    tell();
    throw;
  }
  tell();
  return std::move(*result);
}

py::object raster(const FileNames& files, int workers, const py::object& progress, const py::object& note,
                  const py::kwargs& fields) {
  const jobs::RasterResult map = run_job<jobs::RasterRequest>("visibility raster", &jobs::add_raster_fields,
                                                              files, workers, progress, note, fields);
  const py::object values = std::visit(
      [&](const auto& all) -> py::object {
        using Value = typename std::decay_t<decltype(all)>::value_type;
        py::array_t<Value> array({py::ssize_t{map.grid.rows}, py::ssize_t{map.grid.columns}});
        std::ranges::copy(all, array.mutable_data());
        return array;
      },
      map.band.values);
  py::dict metadata;
  for (const auto& [key, text] : map.metadata) metadata[py::str(key)] = text_of(text);
  // In the order of affine.Affine, which rasterio uses.
  const py::tuple transform = py::make_tuple(map.grid.cell_size, 0.0, map.grid.north_west.x, 0.0,
                                             -map.grid.cell_size, map.grid.north_west.y);
  return answer_type("Map")(values, transform, object_of(map.crs), map.band.no_data, metadata);
}

/// (name, kind, help, form) of every field, as Python names it.
template <class Request>
py::list fields_of(const char* command, void (*add_fields)(const jobs::Fields&, Request&)) {
  Request request;
  const auto table = std::make_shared<jobs::FieldTable>(command);
  add_fields(jobs::Fields(table), request);
  constexpr const char* k_forms[] = {"flag", "value", "text", "repeated", "words"};
  py::list all;
  for (const jobs::FieldEntry& field : table->entries()) {
    if (jobs::is_operand(field)) continue;
    std::string name = jobs::long_name(field);
    std::ranges::replace(name, '-', '_');
    all.append(py::make_tuple(name, field.kind, field.help, k_forms[static_cast<std::size_t>(field.form)]));
  }
  return all;
}

}  // namespace

void add_jobs(py::module_& module) {
  module.def("_raster", &raster, py::arg("files"), py::kw_only(), py::arg("workers") = -1,
             py::arg("progress") = py::none(), py::arg("note") = py::none());
  module.def("_raster_fields",
             [] { return fields_of<jobs::RasterRequest>("visibility raster", &jobs::add_raster_fields); });
}

}  // namespace alidade::python
