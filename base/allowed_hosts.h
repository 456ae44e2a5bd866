// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

// The web servers that files may come from when the user did not name them: catalogs list files,
// servers redirect.

namespace alidade {

/// The host of an http(s) URL in lower case, "example.org", with the port where it is not that of the scheme.
/// Empty: no such URL, or a host with other characters than hosts have.
std::string host_of(std::string_view url);

/// Allows a host for the rest of the process. Errors: it is not in the form that host_of() returns.
void allow_host(const std::string& host);

/// The hosts of allow_host(), and those between commas in the environment variable ALIDADE_ALLOW_HOSTS.
std::vector<std::string> allowed_hosts();

/// Notes that a catalog has listed a remote file. Thread safe, as all functions here.
void note_listed_file(const std::string& name);

/// For a file that a catalog has listed in this process: the hosts that requests for it may be redirected to
/// beside its own. Empty for any other file, whose requests may be redirected to all hosts.
std::optional<std::vector<std::string>> hosts_for(const std::string& name);

}  // namespace alidade
