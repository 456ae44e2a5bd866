// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "jobs/fields.h"
#include "jobs/listener.h"
#include "python/python_arrays.h"

// Jobs as functions of Python.

namespace alidade::python {

/// A request on its way to the answer of a job.
class JobRun {
 public:
  virtual ~JobRun() = default;
  virtual void add_fields(const jobs::Fields& fields) = 0;
  /// Takes values that are arrays, which need not become texts, out of those that were given.
  virtual void take_arrays(const py::dict&) {}
  /// Where the request has the command for metadata; null: nowhere.
  virtual std::string* command() { return nullptr; }
  /// Plans and runs the job, without the GIL. Errors: those of the job.
  virtual void work(jobs::Listener& listener) = 0;
  /// What Python gets. Requires work().
  virtual py::object answer() = 0;
};

/// make(plan, result) makes the answer.
template <class Request, class Answer>
class RequestRun : public JobRun {
 public:
  using AddFields = void (*)(const jobs::Fields&, Request&);

  RequestRun(AddFields add, Answer make) : add_fields_(add), answer_(std::move(make)) {
    if constexpr (requires { request_.returns_films; }) request_.returns_films = true;
  }

  void add_fields(const jobs::Fields& fields) override { add_fields_(fields, request_); }
  std::string* command() override {
    if constexpr (requires { request_.command; })
      return &request_.command;
    else
      return nullptr;
  }
  void work(jobs::Listener& listener) override {
    checked_.emplace(plan(request_));
    result_.emplace(run(*checked_, listener));
  }
  py::object answer() override { return answer_(*checked_, *result_); }

 protected:
  Request request_;

 private:
  using Plan = decltype(plan(std::declval<const Request&>()));
  using Result = decltype(run(std::declval<const Plan&>(), std::declval<jobs::Listener&>()));

  AddFields add_fields_;
  Answer answer_;
  std::optional<Plan> checked_;
  std::optional<Result> result_;
};

/// Whether the output of a job is its answer, or an extra: the answer is returned, too.
enum class Output { extra, answer };

/// A job, whose function has the name of its command.
struct Job {
  std::string command;  ///< "visibility photos"
  std::string summary;  ///< begins the manual of the function; empty for jobs of the core: alidade/jobs.py
  std::function<std::unique_ptr<JobRun>()> begin;
  Output output = Output::extra;
};

template <class Request, class Answer>
Job job(std::string command, std::string summary, void (*add_fields)(const jobs::Fields&, Request&),
        Answer answer, Output output = Output::extra) {
  return {std::move(command), std::move(summary),
          [add_fields, answer] { return std::make_unique<RequestRun<Request, Answer>>(add_fields, answer); },
          output};
}

/// What extensions add to the module.
struct PythonHooks {
  std::vector<Job> jobs;
};

/// Adds what every extension adds that the module is built with. Defined by the build, in the module.
void add_extensions(PythonHooks& hooks);

/// Declares _job_fields(), _added_jobs() and _run_job(), by which alidade/_jobs.py calls the jobs of the core
/// and of extensions.
void add_jobs(py::module_& module, const PythonHooks& extensions);

}  // namespace alidade::python
