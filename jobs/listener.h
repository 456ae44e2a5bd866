// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/progress.h"

namespace alidade::jobs {

/// Who hears what a job says while it works: the program prints it, Python keeps it. Called by one thread at
/// a time, but not always the same one.
class Listener {
 public:
  /// A stage of the work that is under way.
  class Stage {
   public:
    virtual ~Stage() = default;
    /// To be handed to a library; never empty, valid as long as this object.
    virtual Progress callback() = 0;
    /// Counts so much, done by an earlier run, as done, but not for rate and time left.
    virtual void skip(std::uint64_t done) = 0;
    /// The stage is done. One that is destroyed before has failed or was stopped.
    virtual void finish() = 0;
  };

  virtual ~Listener() = default;

  /// An assumption or a measurement on the user's behalf, as one sentence without its full stop.
  virtual void note(std::string_view text) = 0;
  /// What may make an answer wrong.
  virtual void warn(std::string_view text) = 0;
  /// Part of the request cannot be fulfilled, but the job goes on: heard by those who want errors only, too.
  virtual void warn_always(std::string_view text) = 0;
  /// A detail for those who look for the cause of something.
  virtual void detail(std::string_view) {}
  /// Whether notes and warnings are heard at all: some take time to compute.
  virtual bool is_listening() const = 0;
  /// A stage begins. `task`: as "reading"; `unit`: of its counts, "B" or a plural such as "points".
  virtual std::unique_ptr<Stage> begin(std::string task, std::string unit) = 0;
  /// Whether the job is to stop. Called from many threads at once.
  virtual bool stops() const = 0;
};

/// Keeps notes, warnings and stages of a part of the work from `other`, which can still stop it.
class SilentListener : public Listener {
 public:
  /// `other` must outlive this object.
  explicit SilentListener(Listener& other) : other_(other) {}

  void note(std::string_view) override {}
  void warn(std::string_view) override {}
  void warn_always(std::string_view text) override { other_.warn_always(text); }
  bool is_listening() const override { return false; }
  std::unique_ptr<Stage> begin(std::string, std::string) override {
    return std::make_unique<SilentStage>(other_);
  }
  bool stops() const override { return other_.stops(); }

 private:
  class SilentStage : public Stage {
   public:
    explicit SilentStage(const Listener& other) : other_(other) {}
    Progress callback() override {
      return [&other = other_](std::uint64_t, std::uint64_t) { return !other.stops(); };
    }
    void skip(std::uint64_t) override {}
    void finish() override {}

   private:
    const Listener& other_;
  };

  Listener& other_;
};

/// Warns of each text.
inline void warn_all(Listener& listener, const std::vector<std::string>& texts) {
  for (const std::string& text : texts) listener.warn(text);
}

/// Returns what work(progress) returns, as one stage.
template <class Work>
auto in_stage(Listener& listener, std::string task, std::string unit, const Work& work) {
  const std::unique_ptr<Listener::Stage> stage = listener.begin(std::move(task), std::move(unit));
  if constexpr (std::is_void_v<std::invoke_result_t<Work, Progress>>) {
    work(stage->callback());
    stage->finish();
  } else {
    auto result = work(stage->callback());
    stage->finish();
    return result;
  }
}

}  // namespace alidade::jobs
