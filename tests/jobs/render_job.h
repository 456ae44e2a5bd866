// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "jobs/field_table.h"
#include "jobs/render/render.h"
#include "simulation/courtyard.h"
#include "tests/jobs/heard.h"

namespace alidade::test {

using Words = std::vector<std::string>;

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// What a job of images did.
struct RenderOutcome {
  bool is_done = false;
  std::string said;  ///< notes and warnings, then the error
  jobs::RenderResult result;
};

/// Runs jobs of images in a folder of their own.
class RenderJobTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = std::filesystem::temp_directory_path() / fmt::format("alidade_render_{}", ::getpid());
    std::filesystem::create_directories(folder);
    before_ = std::filesystem::current_path();
    std::filesystem::current_path(folder);
  }
  void TearDown() override {
    std::filesystem::current_path(before_);
    std::filesystem::remove_all(folder);
  }

  /// Runs a job that is requested as on a command line; words without hyphens are scenes or clouds.
  RenderOutcome render(const Words& words, bool returns_films = false) {
    RenderOutcome outcome;
    Heard heard;
    try {
      const auto table = std::make_shared<jobs::FieldTable>("render");
      jobs::RenderRequest request;
      request.returns_films = returns_films;
      jobs::add_render_fields(jobs::Fields(table), request);
      give(*table, words);
      table->read();
      outcome.result = jobs::run(jobs::plan(request), heard);
      outcome.is_done = true;
      outcome.said = heard.text();
    } catch (const std::runtime_error& error) {
      outcome.said = heard.text() + error.what() + "\n";
    }
    return outcome;
  }

  void write(const std::string& name, const std::string& text) { std::ofstream(folder / name) << text; }
  std::string read(const std::string& name) const {
    std::ifstream stream(folder / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  /// The pixels of a PNG, without its texts.
  std::string pixels(const std::string& name) const {
    const std::string content = read(name);
    return content.substr(content.find("IDAT"));
  }
  Words names() const {
    Words names;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      names.push_back(entry.path().filename().string());
    std::ranges::sort(names);
    return names;
  }
  /// A cloud of 20 x 20 points, 0.1 apart, without a reference system.
  void write_square(const std::string& name) {
    std::string text;
    for (int i = 0; i < 400; ++i)
      text += fmt::format("{:.1f} {:.1f} 5.0\n", 100.0 + 0.1 * (i % 20), 200.0 + 0.1 * (i / 20));
    write(name, text);
  }
  void write_yard(const std::string& name, std::uint64_t points) {
    simulation::generate_courtyard(folder / name, {.point_count = points});
  }

  std::filesystem::path folder;

 private:
  static void give(jobs::FieldTable& table, const Words& words) {
    Words operands;
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (!words[i].starts_with("-")) {
        operands.push_back(words[i]);
        continue;
      }
      const std::size_t end = words[i].find('=');
      const std::string name = words[i]
                                   .substr(words[i].find_first_not_of('-'))
                                   .substr(0, end == std::string::npos ? end : end - 2);
      const auto field = std::ranges::find_if(table.entries(), [&](const jobs::FieldEntry& entry) {
        return std::ranges::count(jobs::plain_names(entry), name) > 0;
      });
      const bool is_flag = field != table.entries().end() && field->form == jobs::FieldForm::flag;
      if (is_flag)
        table.give(name, {});
      else
        table.give(name, {end == std::string::npos ? words.at(++i) : words[i].substr(end + 1)});
    }
    if (!operands.empty()) table.give("scene", operands);
  }

  std::filesystem::path before_;
};

}  // namespace alidade::test
