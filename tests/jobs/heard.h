// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "jobs/listener.h"

namespace alidade::test {

/// Keeps what a job says.
class Heard : public jobs::Listener {
 public:
  std::vector<std::string> notes, warnings, stages;

  void note(std::string_view text) override { notes.emplace_back(text); }
  void warn(std::string_view text) override { warnings.emplace_back(text); }
  void warn_always(std::string_view text) override { warn(text); }
  bool is_listening() const override { return true; }
  bool stops() const override { return false; }

  std::unique_ptr<Stage> begin(std::string task, std::string) override {
    stages.push_back(std::move(task));
    return std::make_unique<SilentStage>();
  }

  /// All of it, a line each.
  std::string text() const {
    std::string all;
    for (const auto* const texts : {&notes, &warnings})
      for (const std::string& one : *texts) all += one + "\n";
    return all;
  }

 private:
  struct SilentStage : Stage {
    Progress callback() override {
      return [](std::uint64_t, std::uint64_t) { return true; };
    }
    void skip(std::uint64_t) override {}
    void finish() override {}
  };
};

}  // namespace alidade::test
