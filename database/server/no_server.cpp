// SPDX-License-Identifier: MIT
// Replaces server_clouds.cpp in a build without the header of PostgreSQL's client library.
#include "base/error.h"
#include "cloud/cloud_reader.h"
#include "database/server/server_clouds.h"

namespace alidade::database {
namespace {

[[noreturn]] void reject(const ServerName& name) {
  throw file_error(name.shown(), "this program was built without the PostgreSQL client library",
                   "a build with libpq-dev or an equivalent package");
}

}  // namespace

const CloudFormat k_server_format{.name = "PostgreSQL",
                                  .is_named = is_server_name,
                                  .open = [](InputFile input, Damage) -> std::unique_ptr<CloudReader> {
                                    reject(ServerName(input.name()));
                                  }};

bool has_server_parts(const std::string& name) {
  reject(ServerName(name));
}

CloudPart read_server_part(const std::string& name, std::span<const PointFilter>, AttributeSet,
                           const Progress&) {
  reject(ServerName(name));
}

StoredFiles store_on_server(const ServerName& name, const CloudInputs&, const ReadOptions&,
                            const ServerStoreOptions&) {
  reject(name);
}

}  // namespace alidade::database
