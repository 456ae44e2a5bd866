// SPDX-License-Identifier: MIT
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace alidade::test {

/// Debian's chromium, if it is installed.
std::optional<std::filesystem::path> chromium_program();

/// A page in a browser without a window, driven by the DevTools protocol over pipes.
/// Source: https://chromedevtools.github.io/devtools-protocol/
class Chromium {
 public:
  /// Starts it with a profile in `folder`; the page is as wide and high as a screen of so many pixels.
  Chromium(const std::filesystem::path& folder, int width, int height);
  ~Chromium();
  Chromium(const Chromium&) = delete;
  Chromium& operator=(const Chromium&) = delete;

  /// Opens a file by its file:// address, offline, and waits until it is loaded.
  void open(const std::filesystem::path& file);
  /// Value of an expression of JavaScript.
  nlohmann::json evaluate(const std::string& expression);
  /// Presses and releases a key: "b", "ArrowRight".
  void press(const std::string& key);
  /// Presses the mouse or a finger at the first position, lets go at the second one.
  void drag(double from_x, double from_y, double to_x, double to_y);

  /// Errors of the console, uncaught exceptions, and everything that was fetched beside the page itself.
  const std::vector<std::string>& problems() const { return problems_; }

 private:
  /// Sends a command and answers its result; what happens meanwhile is noted.
  nlohmann::json call(const std::string& method, const nlohmann::json& parameters = nlohmann::json::object());
  nlohmann::json next_message();
  void note(const nlohmann::json& event);

  pid_t process_ = -1;
  int to_browser_ = -1, from_browser_ = -1, last_id_ = 0;
  std::string session_, received_;
  std::vector<std::string> problems_;
  bool loaded_ = false;
};

}  // namespace alidade::test
