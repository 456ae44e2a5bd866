// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <string>

#include "base/allowed_hosts.h"
#include "base/error.h"
#include "base/shown_text.h"
#include "base/words.h"
#include "extensions/web/remote_file.h"
#include "jobs/remote_files.h"

namespace alidade::extensions {
namespace {

/// Set by ALIDADE_CACHE, then by fields, of jobs on many threads.
struct SharedRemoteOptions {
  std::mutex mutex;
  geo::RemoteOptions options;
  bool permits_all = false;     ///< --yes
  std::uint64_t permitted = 0;  ///< bytes of whole files so far

  SharedRemoteOptions() {
    if (const char* const folder = std::getenv("ALIDADE_CACHE")) options.cache = folder;
  }
};

SharedRemoteOptions& remote_options() {
  static SharedRemoteOptions& options = *new SharedRemoteOptions;  // never destroyed: threads may read files
  return options;
}

/// Tells the user that a file will be fetched whole, and asks if the process fetches too many bytes of such
/// files. Errors: the user does not agree.
void permit_whole(const geo::WholeFetch& fetch) {
  constexpr std::uint64_t k_most_unasked = 1'000'000'000;
  const jobs::RemoteUser& user = jobs::remote_user();
  const std::scoped_lock lock(remote_options().mutex);
  std::uint64_t& permitted = remote_options().permitted;
  const std::string name = public_name(fetch.name), size = quantity(static_cast<double>(fetch.bytes), "B");
  const std::string all = quantity(static_cast<double>(permitted + fetch.bytes), "B");
  const bool is_large = permitted + fetch.bytes > k_most_unasked && !remote_options().permits_all;
  if (user.note != nullptr)
    user.note(
        fmt::format("{}: fetching the whole index file, {}, into {} ({}); of COPC files (.copc.laz) "
                    "queries fetch only what they need",
                    name, size, fetch.folder.string(), fetch.keeping));
  if (is_large && (user.confirm == nullptr || !user.confirm(fmt::format("{}: fetch {}?", name, size))))
    throw file_error(fetch.name, "index files on the web are fetched whole, more than 1 GB only if you agree",
                     "--yes, or a COPC file, of which only what is needed is fetched",
                     all == size ? size : fmt::format("{}, {} in all", size, all));
  permitted += fetch.bytes;
}

void add_fields(const jobs::Fields& fields) {
  using jobs::UsageError;
  const jobs::Fields group = fields.group("Remote files");
  group.value("--cache", "FOLDER",
              "keep what is fetched from web servers (http, https; not buckets) in this folder, for the next "
              "time (default: the environment variable ALIDADE_CACHE; without it nothing is kept)",
              [](const std::string& text) {
                if (text.empty()) throw UsageError("missing value; expected a folder");
                const std::scoped_lock lock(remote_options().mutex);
                remote_options().options.cache = text;
              });
  group.values("--allow-host", "HOST",
               "accept files of this web server, such as example.org or example.org:8080, in catalogs, and "
               "redirections of such files to it; repeatable (default: files below the catalog; "
               "ALIDADE_ALLOW_HOSTS=HOST,... allows hosts, too)",
               [](const std::string& text) {
                 try {
                   allow_host(lower_case(text));
                 } catch (const Error& error) {
                   throw UsageError(error.what());
                 }
               });
  group.value("--cache-size", "SIZE",
              "largest size of that folder, such as 500M or 20G (default 1G); what was not used for longest "
              "is removed",
              [](const std::string& text) {
                const std::size_t bytes = jobs::parse_size(text);
                const std::scoped_lock lock(remote_options().mutex);
                remote_options().options.cache_bytes = bytes;
              });
  group.flag("--yes",
             "fetch index files (.alidade) on the web of more than 1 GB in all without asking; they are "
             "fetched whole, COPC files (.copc.laz) only in part",
             [] {
               const std::scoped_lock lock(remote_options().mutex);
               remote_options().permits_all = true;
             });
}

std::unique_ptr<RemoteFile> open(const std::string& name) {
  geo::RemoteOptions options = [] {
    const std::scoped_lock lock(remote_options().mutex);
    return remote_options().options;
  }();
  options.is_interrupted = jobs::remote_user().is_interrupted;
  options.permit = permit_whole;
  options.hosts = hosts_for(name);
  return geo::open_remote_file(name, options);
}

}  // namespace

void set_up_web() {
  set_remote_files(open);
  jobs::set_remote_access({.add_fields = add_fields, .traffic = geo::remote_traffic});
}

}  // namespace alidade::extensions
