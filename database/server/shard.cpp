// SPDX-License-Identifier: MIT
#include "database/server/shard.h"

#include <algorithm>
#include <charconv>

#include "base/error.h"

namespace alidade {
namespace {

[[noreturn]] void refuse(std::string_view text, std::string problem) {
  // What is in front of an @ may be a password, which must not stand in a message.
  const std::size_t at = text.rfind('@');
  const std::string found(at == std::string_view::npos ? text : text.substr(at));
  throw Error({.problem = std::move(problem),
               .expected = "HOST/DATABASE or HOST:PORT/DATABASE",
               .found = (at == std::string_view::npos ? "" : "...") + found});
}

int parse_port(std::string_view text, std::string_view whole) {
  int port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc() || end != text.data() + text.size() || port < 1 || port > 65535)
    refuse(whole, "a shard's port is no number from 1 to 65535");
  return port;
}

/// Neither what programs take for an option or a setting, nor what terminals take for a command.
bool is_plain(std::string_view name) {
  const auto is_strange = [](char letter) {
    return static_cast<unsigned char>(letter) <= 0x20 || letter == 0x7f || letter == '=';
  };
  return !name.empty() && name.front() != '-' && std::ranges::none_of(name, is_strange);
}

}  // namespace

Shard parse_shard(std::string_view text) {
  if (text.find('@') != std::string_view::npos)
    refuse(text, "users and passwords do not belong to the name of a shard, but to its user mapping");
  const std::size_t slash = text.rfind('/');
  if (slash == std::string_view::npos) refuse(text, "a shard's name has no database");
  std::string_view host = text.substr(0, slash);
  Shard shard{.host = {}, .database = std::string(text.substr(slash + 1))};

  const std::size_t bracket = host.starts_with('[') ? host.find(']') : std::string_view::npos;
  const std::size_t colon = host.find(':', bracket == std::string_view::npos ? 0 : bracket);
  if (colon != std::string_view::npos) {
    shard.port = parse_port(host.substr(colon + 1), text);
    host = host.substr(0, colon);
  }
  if (bracket != std::string_view::npos) {
    if (bracket + 1 != host.size()) refuse(text, "a shard's host is no address");
    host = host.substr(1, bracket - 1);
  }
  shard.host = host;
  if (!is_plain(shard.host) || shard.host.find('/') != std::string::npos || !is_plain(shard.database))
    refuse(text, "a shard's name lacks host or database");
  return shard;
}

}  // namespace alidade
