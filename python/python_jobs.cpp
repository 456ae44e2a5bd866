// SPDX-License-Identifier: MIT
#include "python/python_jobs.h"

#include <fmt/format.h>
#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/shown_text.h"
#include "jobs/field_table.h"
#include "python/job_answers.h"
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

/// A text as Python holds it, names of files in any encoding.
std::string bytes_of(const py::handle& text) {
  if (!py::isinstance<py::str>(text)) return text.cast<std::string>();
  const auto bytes =
      py::reinterpret_steal<py::bytes>(PyUnicode_AsEncodedString(text.ptr(), "utf-8", "surrogateescape"));
  if (!bytes) throw py::error_already_set();
  return bytes;
}

bool is_text(const py::handle& value) {
  return py::isinstance<py::str>(value) || py::isinstance<py::bytes>(value) ||
         py::hasattr(value, "__fspath__");
}

/// True and False of Python and of NumPy.
bool is_bool(const py::handle& value) {
  return py::isinstance<py::bool_>(value) ||
         py::isinstance(value, py::module_::import("numpy").attr("bool_"));
}

/// A value of a type that a field does not have. `expected`: "a name".
py::type_error wrong_type(const std::string& expected, const py::handle& value) {
  return py::type_error(
      fmt::format("expected {}, found {}", expected,
                  py::str(py::type::handle_of(value).attr("__name__")).cast<std::string>()));
}

/// The number as an object of Python itself, made by one of its methods; none: it has no such method, or no
/// number, as arrays.
py::object number_by(const char* method, const py::handle& value) {
  if (!py::hasattr(value, method)) return py::none();
  try {
    return value.attr(method)();
  } catch (py::error_already_set& error) {
    if (!error.matches(PyExc_TypeError)) throw;
    return py::none();
  }
}

/// Whether NumPy has the value as one of the kinds, "c" for complex numbers and so on.
bool is_of_kind(const py::handle& value, std::string_view kinds) {
  const py::object kind = py::getattr(py::getattr(value, "dtype", py::none()), "kind", py::none());
  return py::isinstance<py::str>(kind) && kinds.find(kind.cast<std::string>()) != kinds.npos;
}

/// A number, text or date as a field reads it. Errors: TypeError, if it is something else.
std::string word_of(const py::handle& value) {
  if (py::hasattr(value, "__fspath__")) return bytes_of(value.attr("__fspath__")());
  if (is_text(value)) return bytes_of(value);
  // NumPy would drop the imaginary part, or the unit of a time.
  if (is_of_kind(value, "cm")) throw wrong_type("a number, a text, or a sequence of them", value);
  // The shortest text that is this number again; NumPy's own names its type.
  if (const py::object whole = number_by("__index__", value); !whole.is_none()) return py::str(whole);
  if (const py::object number = number_by("__float__", value); !number.is_none()) return py::repr(number);
  const bool is_date = py::hasattr(value, "isoformat") ||
                       py::isinstance(value, py::module_::import("numpy").attr("datetime64"));
  if (is_date) return py::str(value);
  throw wrong_type("a number, a text, or a sequence of them", value);
}

/// Sequences, sets and arrays, but no array without dimensions, which is a number.
bool is_list(const py::handle& value) {
  if (is_text(value) || py::isinstance<py::dict>(value)) return false;
  if (!py::hasattr(value, "__len__") || !py::hasattr(value, "__iter__")) return false;
  return !py::hasattr(value, "ndim") || !py::object(value.attr("ndim")).equal(py::int_(0));
}

/// "1.0,2.5" of (1.0, 2.5).
std::string text_of_value(const py::handle& value, const char* separator = ",") {
  if (!is_list(value)) return word_of(value);
  std::string text;
  for (const py::handle& one : value) text += (text.empty() ? "" : separator) + word_of(one);
  return text;
}

/// What is between the parts of a field's value: of "WxH" x, of "I/N" a slash, else a comma.
const char* separator_of(const std::string& kind) {
  if (kind == "WxH") return "x";
  return kind == "I/N" ? "/" : ",";
}

/// The texts of a field that takes many: one for each item; a single position is one item.
std::vector<std::string> texts_of_values(const py::handle& value) {
  if (!is_list(value)) return {text_of_value(value)};
  std::vector<std::string> texts;
  for (const py::handle& one : value) {
    const bool is_item = texts.empty() && !is_list(one) && !is_text(one);
    if (is_item) return {text_of_value(value)};
    texts.push_back(text_of_value(one));
  }
  return texts;
}

/// Errors: TypeError, if an operand is no name of a file, or list of names.
void check_names(const py::handle& value) {
  bool are_names = is_text(value) || is_list(value);
  if (is_list(value))
    for (const py::handle& one : value) are_names = are_names && is_text(one);
  if (!are_names) throw wrong_type("a name, or a list of names", value);
}

/// The texts of a field of this form. Errors: TypeError, if the value is none that the field has.
std::vector<std::string> texts_of(const jobs::FieldEntry& field, const py::handle& value) {
  if (field.form == jobs::FieldForm::flag) {
    if (!is_bool(value)) throw wrong_type("True or False", value);
    return {};
  }
  if (is_bool(value)) throw wrong_type(field.kind, value);
  if (jobs::is_operand(field)) check_names(value);
  // Names and other texts are not joined by commas, which they may have.
  const bool is_text_only = field.form == jobs::FieldForm::text || jobs::is_operand(field);
  if (is_text_only || field.form == jobs::FieldForm::repeated || field.form == jobs::FieldForm::words)
    return texts_of_values(value);
  const bool is_no_class = jobs::own_name(field) == "ignore_classes" && is_list(value) && py::len(value) == 0;
  return {is_no_class ? "none" : text_of_value(value, separator_of(field.kind))};
}

/// Takes targets that are arrays out of the values: they are read without making texts of them. The request
/// refers to what is returned. Lists of texts, and empty lists, stay in the values.
std::vector<Doubles> take_targets(const py::dict& values, jobs::QueryRequest& request) {
  std::vector<Doubles> taken;
  for (std::size_t i = 0; i < jobs::k_target_families; ++i) {
    const auto family = static_cast<jobs::TargetFamily>(i);
    const jobs::TargetKind& kind = jobs::target_kind(family);
    for (const char* const option : {kind.texts_option, kind.value_option}) {
      const std::string name = option + std::string_view("--").size();
      const py::object value = values.attr("get")(name);
      if (!is_list(value)) continue;
      const py::array array = py::array::ensure(value);
      if (array && array.ndim() == 1 && (array.size() == 0 || is_text(array[py::int_(0)]))) continue;
      const Doubles given = real_numbers(array ? array : value, name.c_str());
      const auto width = static_cast<py::ssize_t>(kind.columns.size()), found = given.shape(given.ndim() - 1);
      if (found < static_cast<py::ssize_t>(kind.required_count()) || found > width)
        throw input_error(fmt::format("{} has the wrong shape", name), fmt::format("rows of {}", kind.form()),
                          "shape " + shape_text(given));
      Doubles& rows = taken.emplace_back(Shape{given.size() / found, width});
      std::fill_n(rows.mutable_data(), rows.size(), std::numeric_limits<double>::quiet_NaN());
      for (py::ssize_t row = 0; row < rows.shape(0); ++row)
        std::copy_n(given.data() + row * found, found, rows.mutable_data(row, 0));
      check_that(!request.given(family).rows, "targets given twice",
                 fmt::format("{} or {}", kind.texts_option, kind.value_option));
      request.given(family).rows = std::span(rows.data(), static_cast<std::size_t>(rows.size()));
      values.attr("pop")(name);
    }
  }
  return taken;
}

/// A query, whose targets may be arrays.
template <class Answer>
class QueryRun : public RequestRun<jobs::QueryRequest, Answer> {
 public:
  using RequestRun<jobs::QueryRequest, Answer>::RequestRun;
  void take_arrays(const py::dict& values) override { targets_ = take_targets(values, this->request_); }

 private:
  std::vector<Doubles> targets_;  ///< the request refers to them
};

/// What job_answers.h makes of the result of a job of the core.
constexpr auto k_answer = [](const auto& plan, auto& result) { return answer_of(plan, result); };

template <class Request>
Job core_job(const char* command, void (*add_fields)(const jobs::Fields&, Request&),
             Output output = Output::extra) {
  return job(command, "", add_fields, k_answer, output);
}

/// Without fields of those who print the result.
void add_compare_fields(const jobs::Fields& fields, jobs::CompareRequest& request) {
  jobs::add_compare_fields(fields, request);
}

void add_sql_fields(const jobs::Fields& fields, jobs::SqlRequest& request) {
  jobs::add_sql_fields(fields, request);
}

std::vector<Job> core_jobs() {
  using enum Output;
  return {core_job("info", &jobs::add_info_fields),
          core_job("generate", &jobs::add_generate_fields),
          core_job("index", &jobs::add_index_fields, answer),
          core_job("catalog", &jobs::add_catalog_fields, answer),
          core_job("convert", &jobs::add_convert_fields, answer),
          core_job("compare", &add_compare_fields),
          {"query", "",
           [] { return std::make_unique<QueryRun<decltype(k_answer)>>(&jobs::add_query_fields, k_answer); }},
          core_job("render", &jobs::add_render_fields),
          core_job("merge", &jobs::add_merge_fields),
          core_job("sql", &add_sql_fields),
          core_job("sql load", &jobs::add_load_fields),
          core_job("sql rewrite", &jobs::add_rewrite_fields),
          core_job("visibility points", &jobs::add_points_fields),
          core_job("visibility raster", &jobs::add_raster_fields),
          core_job("visibility horizon", &jobs::add_horizon_fields),
          core_job("visibility sky", &jobs::add_sky_fields),
          core_job("visibility sun", &jobs::add_sun_fields),
          core_job("visibility lines", &jobs::add_lines_fields),
          core_job("visibility summary", &jobs::add_summary_fields)};
}

/// How a job is called.
struct Call {
  py::dict values;  ///< of its fields; the job may take some out
  int workers;
  py::object progress;
  py::object note;  ///< called with what the job notes; None: nobody hears it
};

/// Plans and runs a job.
py::object run_job(const Job& job, const Call& call) {
  const std::unique_ptr<JobRun> run = job.begin();
  const auto table = std::make_shared<jobs::FieldTable>(job.command, &is_interrupted);
  run->add_fields(jobs::Fields(table));
  std::vector<std::string> notes, warnings;
  // Also after an error: what was said before may explain it.
  const auto tell = [&] {
    for (const std::string& text : notes)
      if (!call.note.is_none()) call.note(text_of(table->in_own_words(text)));
    for (std::string& text : warnings) text = table->in_own_words(text);
    warn(warnings, 2);
  };
  try {
    if (job.output == Output::extra) table->waive("output");
    run->take_arrays(call.values);
    std::set<const jobs::FieldEntry*> given;
    for (const auto& [key, value] : call.values) {
      const std::string name = py::str(key);
      give(*table, name, value);
      const jobs::FieldEntry& field = table->entry(name);
      if (!value.is_none() && !given.insert(&field).second)
        throw py::type_error(jobs::own_name(field) + " is given twice");
    }
    if (std::string* const command = run->command())
      *command = jobs::command_text(*table, jobs::k_silent_image_options);
    run_watched(call.workers, call.progress, [&](const Progress& watch) {
      table->read();
      PythonListener listener(watch, notes, warnings);
      run->work(listener);
    });
  } catch (const jobs::UsageError& error) {
    throw Error({.problem = table->in_own_words(error.what())});
  } catch (const Error& error) {
    tell();
    throw Error({.problem = table->in_own_words(error.what())});
  } catch (...) {
    tell();
    throw;
  }
  tell();
  return run->answer();
}

/// (name, kind, help, form, whether it is an operand, whether it is required) of every field, as Python names
/// it.
py::list fields_of(const Job& job) {
  const auto table = std::make_shared<jobs::FieldTable>(job.command);
  job.begin()->add_fields(jobs::Fields(table));
  constexpr const char* k_forms[] = {"flag", "value", "text", "repeated", "words"};
  py::list all;
  for (const jobs::FieldEntry& field : table->entries())
    all.append(py::make_tuple(jobs::own_name(field), field.kind, table->in_own_words(field.help),
                              k_forms[static_cast<std::size_t>(field.form)], jobs::is_operand(field),
                              field.is_required));
  return all;
}

}  // namespace

void give(jobs::FieldTable& table, const std::string& name, const py::handle& value) {
  const jobs::FieldEntry& field = table.entry(name);
  if (value.is_none() || (is_bool(value) && !value.cast<bool>())) return;
  const bool is_empty = is_list(value) && py::len(value) == 0;
  const bool takes_none = field.form == jobs::FieldForm::repeated || field.form == jobs::FieldForm::words ||
                          (name == "ignore_classes" && field.kind == "LIST");
  if (is_empty && takes_none && !field.is_required) return;
  std::vector<std::string> texts;
  try {
    texts = texts_of(field, value);
  } catch (const py::type_error& error) {
    throw py::type_error(name + ": " + error.what());
  }
  table.give(name, std::move(texts));
}

void add_jobs(py::module_& module, const PythonHooks& extensions) {
  static std::vector<Job> all;
  all = core_jobs();
  all.insert(all.end(), extensions.jobs.begin(), extensions.jobs.end());
  module.def("_job_fields", [] {
    py::dict fields;
    for (const Job& job : all) fields[job.command.c_str()] = fields_of(job);
    return fields;
  });
  module.def("_added_jobs", [] {
    py::dict summaries;
    for (const Job& job : all)
      if (!job.summary.empty()) summaries[job.command.c_str()] = job.summary;
    return summaries;
  });
  module.def("_run_job", [](const std::string& command, const py::dict& values, int workers,
                            const py::object& progress, const py::object& note) {
    return run_job(*std::ranges::find(all, command, &Job::command), {values, workers, progress, note});
  });
}

}  // namespace alidade::python
