// SPDX-License-Identifier: MIT
#include "base/allowed_hosts.h"

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <unordered_set>

#include "base/error.h"
#include "base/words.h"

namespace alidade {
namespace {

struct Hosts {
  std::mutex mutex;
  std::vector<std::string> allowed;
  std::unordered_set<std::string> listed;
};

Hosts& hosts() {
  static Hosts& hosts = *new Hosts;  // never destroyed: other static objects may read files
  return hosts;
}

bool is_host_character(char character) {
  return (character >= 'a' && character <= 'z') || (character >= '0' && character <= '9') ||
         std::string_view(".-_:[]").find(character) != std::string_view::npos;
}

}  // namespace

std::string host_of(std::string_view url) {
  const std::string begin = lower_case(url.substr(0, url.find("://") + 3));
  if (begin != "http://" && begin != "https://") return {};
  url = url.substr(begin.size(), url.find_first_of("/?#", begin.size()) - begin.size());
  std::string host = lower_case(url.substr(url.rfind('@') + 1));
  const std::string_view port = begin == "http://" ? ":80" : ":443";
  if (host.ends_with(port)) host.resize(host.size() - port.size());
  return std::ranges::all_of(host, is_host_character) ? host : std::string();
}

void allow_host(const std::string& host) {
  check_that(!host.empty() && host_of("https://" + host) == host, "invalid host",
             "a name such as example.org or example.org:8080", quote(host));
  const std::scoped_lock lock(hosts().mutex);
  hosts().allowed.push_back(host);
}

std::vector<std::string> allowed_hosts() {
  std::vector<std::string> all;
  if (const char* const given = std::getenv("ALIDADE_ALLOW_HOSTS")) {
    std::vector<std::string_view> words;
    split_cells(given, ',', words);
    for (const std::string_view word : words) all.push_back(lower_case(word));
  }
  const std::scoped_lock lock(hosts().mutex);
  all.insert(all.end(), hosts().allowed.begin(), hosts().allowed.end());
  return all;
}

void note_listed_file(const std::string& name) {
  const std::scoped_lock lock(hosts().mutex);
  hosts().listed.insert(name);
}

std::optional<std::vector<std::string>> hosts_for(const std::string& name) {
  {
    const std::scoped_lock lock(hosts().mutex);
    if (!hosts().listed.contains(name)) return std::nullopt;
  }
  return allowed_hosts();
}

}  // namespace alidade
