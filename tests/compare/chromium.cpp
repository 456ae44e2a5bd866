// SPDX-License-Identifier: MIT
#include "tests/compare/chromium.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

namespace alidade::test {
namespace {

using nlohmann::json;

constexpr int k_patience = 120'000;  // milliseconds; a busy machine takes seconds

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error("chromium: " + what);
}

/// Moves the descriptors to 3 and 4, where the browser looks for them, and becomes the browser.
[[noreturn]] void become_browser(int in, int out, const std::vector<std::string>& words) {
  // Out of the way first: one of them may be 3 or 4 already.
  const int high_in = ::fcntl(in, F_DUPFD, 10), high_out = ::fcntl(out, F_DUPFD, 10);
  ::dup2(high_in, 3);
  ::dup2(high_out, 4);
  const int nowhere = ::open("/dev/null", O_RDWR);
  for (const int descriptor : {0, 1, 2}) ::dup2(nowhere, descriptor);
  std::vector<char*> pointers;
  for (const std::string& word : words) pointers.push_back(const_cast<char*>(word.c_str()));
  pointers.push_back(nullptr);
  ::setpgid(0, 0);
  ::execv(pointers[0], pointers.data());
  ::_exit(126);
}

}  // namespace

std::optional<std::filesystem::path> chromium_program() {
  const std::filesystem::path program = "/usr/bin/chromium";
  if (!std::filesystem::exists(program)) return {};
  return program;
}

Chromium::Chromium(const std::filesystem::path& folder, int width, int height) {
  std::array<int, 2> down{}, up{};
  if (::pipe(down.data()) != 0 || ::pipe(up.data()) != 0) fail("no pipes");
  const std::vector<std::string> words = {chromium_program().value(),
                                          "--headless",
                                          "--no-sandbox",
                                          "--disable-gpu",
                                          "--disable-dev-shm-usage",
                                          "--no-first-run",
                                          "--disable-extensions",
                                          "--disable-background-networking",
                                          "--remote-debugging-pipe",
                                          "--user-data-dir=" + (folder / "profile").string(),
                                          "about:blank"};
  process_ = ::fork();
  if (process_ == 0) become_browser(down[0], up[1], words);
  ::setpgid(process_, process_);
  ::close(down[0]);
  ::close(up[1]);
  to_browser_ = down[1];
  from_browser_ = up[0];
  const json target = call("Target.createTarget", {{"url", "about:blank"}});
  session_ = call("Target.attachToTarget", {{"targetId", target["targetId"]}, {"flatten", true}})["sessionId"]
                 .get<std::string>();
  for (const char* const domain : {"Page", "Runtime", "Log", "Network"})
    call(std::string(domain) + ".enable");
  call("Emulation.setDeviceMetricsOverride",
       {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", width < 500}});
  call("Network.emulateNetworkConditions",
       {{"offline", true}, {"latency", 0}, {"downloadThroughput", 0}, {"uploadThroughput", 0}});
}

Chromium::~Chromium() {
  ::close(to_browser_);
  ::close(from_browser_);
  // The browser has processes of its own, all of them in its group.
  ::kill(-process_, SIGKILL);
  ::waitpid(process_, nullptr, 0);
}

void Chromium::open(const std::filesystem::path& file) {
  loaded_ = false;
  const json result = call("Page.navigate", {{"url", "file://" + file.string()}});
  if (result.contains("errorText"))
    fail("cannot open " + file.string() + ": " + result["errorText"].get<std::string>());
  while (!loaded_) note(next_message());
}

json Chromium::evaluate(const std::string& expression) {
  const json result =
      call("Runtime.evaluate", {{"expression", expression}, {"returnByValue", true}, {"awaitPromise", true}});
  if (result.contains("exceptionDetails")) fail(expression + ": " + result["exceptionDetails"].dump());
  return result["result"].value("value", json());
}

void Chromium::press(const std::string& key) {
  json event{{"type", "keyDown"}, {"key", key}};
  if (key.size() == 1) event["text"] = key;
  call("Input.dispatchKeyEvent", event);
  event["type"] = "keyUp";
  event.erase("text");
  call("Input.dispatchKeyEvent", event);
}

void Chromium::drag(double from_x, double from_y, double to_x, double to_y) {
  const auto send = [this](const char* type, double x, double y) {
    call("Input.dispatchMouseEvent",
         {{"type", type}, {"x", x}, {"y", y}, {"button", "left"}, {"buttons", 1}, {"clickCount", 1}});
  };
  send("mousePressed", from_x, from_y);
  send("mouseMoved", (from_x + to_x) / 2.0, (from_y + to_y) / 2.0);
  send("mouseMoved", to_x, to_y);
  send("mouseReleased", to_x, to_y);
}

json Chromium::call(const std::string& method, const json& parameters) {
  json message{{"id", ++last_id_}, {"method", method}, {"params", parameters}};
  if (!session_.empty()) message["sessionId"] = session_;
  const std::string text = message.dump();
  // The NUL behind the text ends the message.
  for (std::size_t sent = 0; sent < text.size() + 1;) {
    const ssize_t count = ::write(to_browser_, text.c_str() + sent, text.size() + 1 - sent);
    if (count <= 0) fail("does not listen");
    sent += static_cast<std::size_t>(count);
  }
  while (true) {
    const json answer = next_message();
    if (answer.value("id", 0) != last_id_) {
      note(answer);
      continue;
    }
    if (answer.contains("error")) fail(method + ": " + answer["error"].dump());
    return answer["result"];
  }
}

json Chromium::next_message() {
  std::size_t end = received_.find('\0');
  while (end == std::string::npos) {
    pollfd waiting{from_browser_, POLLIN, 0};
    if (::poll(&waiting, 1, k_patience) <= 0) fail("does not answer");
    std::array<char, 65536> bytes{};
    const ssize_t count = ::read(from_browser_, bytes.data(), bytes.size());
    if (count <= 0) fail("has ended");
    received_.append(bytes.data(), static_cast<std::size_t>(count));
    end = received_.find('\0');
  }
  json message = json::parse(received_.substr(0, end));
  received_.erase(0, end + 1);
  return message;
}

void Chromium::note(const json& event) {
  const std::string method = event.value("method", "");
  if (method == "Page.loadEventFired") loaded_ = true;
  if (method == "Runtime.exceptionThrown" || method == "Log.entryAdded")
    problems_.push_back(event["params"].dump());
  if (method == "Runtime.consoleAPICalled" && event["params"]["type"] != "log")
    problems_.push_back(event["params"].dump());
  if (method == "Network.requestWillBeSent") {
    const std::string address = event["params"]["request"]["url"];
    if (!address.starts_with("data:") && !address.starts_with("file:"))
      problems_.push_back("fetched " + address);
  }
}

}  // namespace alidade::test
