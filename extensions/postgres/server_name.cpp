// SPDX-License-Identifier: MIT
#include "extensions/postgres/server_name.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/words.h"

namespace alidade::database {
namespace {

constexpr std::string_view k_schemes[] = {"postgresql://", "postgres://"};
constexpr const char* k_form = "postgresql://HOST:PORT/DATABASE?table=NAME";

[[noreturn]] void reject_name(std::string problem, std::string expected = k_form) {
  throw Error({.problem = std::move(problem), .expected = std::move(expected)});
}

[[noreturn]] void reject_password() {
  reject_name("the server name contains a password, which other users can see in command lines",
              "the password in ~/.pgpass, PGPASSFILE or PGPASSWORD");
}

std::string decoded(std::string_view text) {
  std::optional<std::string> plain = percent_decoded(text);
  if (!plain) reject_name("the server name has a '%' without a character code", "%25 for a '%' itself");
  if (plain->find('\0') != std::string::npos) reject_name("the server name contains NUL");
  return *std::move(plain);
}

std::string encoded(std::string_view text) {
  std::string result;
  for (const char character : text) {
    const auto byte = static_cast<unsigned char>(character);
    const bool is_plain = byte > 0x7f || std::isalnum(byte) != 0 ||
                          std::string_view("-_.~/ '()*,;!$").find(character) != std::string_view::npos;
    result += is_plain ? std::string(1, character) : fmt::format("%{:02X}", byte);
  }
  return result;
}

/// Whether a parameter is secret: "password", "sslpassword", and similar ones of newer versions.
bool is_secret(const std::string& keyword) {
  const std::string lower = lower_case(keyword);
  return lower.find("password") != std::string::npos || lower.find("secret") != std::string::npos;
}

/// Removes the part before the first of these marks from `text`, with the mark, and returns it.
std::string_view split(std::string_view& text, char mark) {
  const std::size_t end = std::min(text.find(mark), text.size());
  const std::string_view front = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return front;
}

}  // namespace

bool is_server_name(std::string_view text) {
  return std::ranges::any_of(k_schemes, [&](std::string_view scheme) { return text.starts_with(scheme); });
}

HostAndPort split_host(std::string_view text) {
  HostAndPort found{.host = text};
  const std::size_t bracket = text.starts_with('[') ? text.find(']') : std::string_view::npos;
  const std::size_t colon = text.find(':', bracket == std::string_view::npos ? 0 : bracket);
  if (colon != std::string_view::npos) {
    found.port = text.substr(colon + 1);
    found.host = text.substr(0, colon);
  }
  if (bracket != std::string_view::npos) {
    found.is_address = bracket + 1 == found.host.size();
    found.host = found.host.substr(1, bracket - 1);
  }
  return found;
}

std::optional<int> parse_port(std::string_view text) {
  const std::optional<int> port = parse_count<int>(text);
  return port && *port >= 1 && *port <= 65535 ? port : std::nullopt;
}

ServerName::ServerName(std::string_view text) {
  for (const std::string_view scheme : k_schemes) {
    if (text.starts_with(scheme)) text.remove_prefix(scheme.size());
  }
  const auto take = [&](const char* keyword, std::string_view value) {
    if (!value.empty()) parameters.emplace_back(keyword, decoded(value));
  };
  std::string_view rest = text;
  // A password may have any mark, so it ends at the last @; an @ elsewhere in a name must be encoded.
  const std::size_t at = text.rfind('@', text.find("?"));
  if (at != std::string_view::npos) {
    const std::string user(rest.substr(0, at));
    rest.remove_prefix(at + 1);
    if (decoded(user).find(':') != std::string::npos) reject_password();
    take("user", user);
  }
  std::string_view server = split(rest, '?');
  const auto [host, port, is_address] = split_host(split(server, '/'));
  if (port) {
    take("port", *port);
    if (!parse_port(parameter("port"))) reject_name("the port is not a number from 1 to 65535");
  }
  if (!is_address) reject_name("invalid server host");
  take("host", host);
  take("dbname", server);
  while (!rest.empty()) {
    std::string_view value = split(rest, '&');
    const std::string keyword = decoded(split(value, '='));
    if (is_secret(keyword)) reject_password();
    // This may be a part of a password with marks in it, which must not be in a message.
    if (keyword.empty() || keyword.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") != std::string::npos)
      reject_name("the server name has a parameter that is not KEYWORD=VALUE");
    if (keyword == "table")
      table = decoded(value);
    else if (keyword == "schema")
      schema = decoded(value);
    else
      parameters.emplace_back(keyword, decoded(value));
  }
}

std::string ServerName::parameter(std::string_view keyword) const {
  const auto found = std::find_if(parameters.rbegin(), parameters.rend(),
                                  [&](const auto& pair) { return pair.first == keyword; });
  return found == parameters.rend() ? std::string() : found->second;
}

std::string ServerName::shown() const {
  const std::string host = parameter("host"), port = parameter("port");
  return fmt::format("postgresql://{}{}{}/{}{}{}",
                     host.find(':') == std::string::npos ? encoded(host) : "[" + host + "]",
                     port.empty() ? "" : ":", port, encoded(parameter("dbname")),
                     table.empty() ? "" : "?table=", encoded(table));
}

}  // namespace alidade::database
