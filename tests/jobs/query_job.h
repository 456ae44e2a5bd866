// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "jobs/field_table.h"
#include "jobs/query/query.h"
#include "tests/jobs/heard.h"

namespace alidade::test {

/// Fields and their values as the program takes them.
using Words = std::vector<std::string>;

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Query jobs on files in a folder of their own.
class QueryJob : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = std::filesystem::temp_directory_path() / ("alidade_query_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  /// Names of files are those in the folder. Errors: jobs::UsageError.
  jobs::QueryRequest request(const std::string& cloud, const Words& words) const {
    constexpr std::array<std::string_view, 8> k_files = {"--rays",   "--lines", "--cones",  "--path",
                                                         "--planes", "--boxes", "--points", "-o"};
    jobs::QueryRequest request;
    const auto table = std::make_shared<jobs::FieldTable>("query");
    jobs::add_query_fields(jobs::Fields(table), request);
    for (std::size_t i = 0; i < words.size(); ++i) {
      const std::string& name = words[i];
      const bool is_flag = i + 1 == words.size() || words[i + 1].starts_with("--") || words[i + 1] == "-o";
      Words values;
      if (!is_flag) values.push_back(words[++i]);
      if (std::ranges::count(k_files, name) > 0) values.back() = (folder / values.back()).string();
      table->give(name.substr(name.find_first_not_of('-')), values);
    }
    table->give("cloud", {(folder / cloud).string()});
    table->read();
    return request;
  }

  /// The answers as text.
  std::string query(const std::string& cloud, const Words& words) {
    jobs::QueryRequest asked = request(cloud, words);
    std::string text;
    asked.write_text = [&](std::string_view piece) { text += piece; };
    heard = {};
    run(jobs::plan(asked), heard);
    return text;
  }

  /// The error that a query ends with, which leaves no text and no file behind.
  std::string rejected(const std::string& cloud, const Words& words) {
    const std::vector<std::string> before = names();
    std::string text;
    try {
      text = query(cloud, words);
    } catch (const Error& error) {
      EXPECT_EQ(names(), before);
      return error.what();
    } catch (const jobs::UsageError& error) {
      return error.what();
    }
    ADD_FAILURE() << "there is no error but\n" << text.substr(0, 300);
    return "";
  }

  void write(const std::string& name, const std::string& content) const {
    std::ofstream(folder / name, std::ios::binary) << content;
  }
  std::string read(const std::string& name) const {
    std::ifstream stream(folder / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  /// Names of all files in the folder, sorted.
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      all.push_back(entry.path().filename().string());
    std::ranges::sort(all);
    return all;
  }

  std::filesystem::path folder;
  Heard heard;
};

}  // namespace alidade::test
