// SPDX-License-Identifier: MIT
#include <memory>

#include "base/error.h"
#include "base/scratch_file.h"
#include "extensions/postgres/server_clouds.h"
#include "jobs/cloud_formats.h"

namespace alidade::extensions {
namespace {

/// A table of a server.
class TableStore final : public jobs::CloudStore {
 public:
  std::string form() const override { return "postgresql://HOST/DATABASE?table=NAME"; }
  bool is_named(const std::filesystem::path& output) const override {
    return database::is_server_name(output.string());
  }
  std::string check(const jobs::StoreTarget& target) const override { return name_of(target).shown(); }

  jobs::OpenStore open(const jobs::StoreTarget& target) const override {
    const auto table = std::make_shared<database::ServerStore>(name_of(target), target.overwrite);
    return {temporary_folder(), [table](database::OrderedCloud& cloud, const Progress& progress) {
              table->store(cloud, progress);
            }};
  }

 private:
  static database::ServerName name_of(const jobs::StoreTarget& target) {
    database::ServerName name(target.output.string());
    if (!name.table.empty() && !target.table.empty())
      throw file_error(name.shown(), "duplicate table name", "?table= or --table");
    if (name.table.empty()) name.table = target.table.empty() ? "points" : target.table;
    return name;
  }
};

}  // namespace

void set_up_postgres() {
  jobs::add_format(
      {.facts = {"PostgreSQL", "postgresql://...", "", "read, write",
                 "alidade sql load; extension alidade_pg prunes"},
       .format = &database::k_server_format,
       .shown = [](const std::string& name) { return database::ServerName(name).shown(); },
       .part_unit = "points",
       .has_parts = database::has_server_parts,
       .read_part = database::read_server_part,
       .make_store = []() -> std::shared_ptr<jobs::CloudStore> { return std::make_shared<TableStore>(); }});
}

}  // namespace alidade::extensions
