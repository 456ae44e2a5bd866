// SPDX-License-Identifier: MIT
#include <cstdint>
#include <memory>
#include <optional>

#include "base/words.h"
#include "extensions/parquet/write_parquet.h"
#include "geo/reproject.h"
#include "jobs/cloud_formats.h"

namespace alidade::extensions {
namespace {

/// The settings of a Parquet file.
class ParquetStore final : public jobs::CloudStore {
 public:
  std::string form() const override { return ".parquet"; }
  bool is_named(const std::filesystem::path& output) const override {
    return has_extension(output, {".parquet"});
  }

  void add_fields(const jobs::Fields& fields) override {
    fields.flag("--geometry",
                "Parquet: also write a column of WKB points and the metadata of GeoParquet 1.1, for GIS",
                geometry_);
    fields.count("--group-points", "N",
                 "Parquet: points per row group, 1024 to 1048576 (default: 65536); fewer where these take "
                 "more than 32 MiB",
                 group_points_, 1024, 1048576);
  }

  std::string misplaced() const override {
    return geometry_ ? "--geometry requires Parquet" : group_points_ ? "--group-points requires Parquet" : "";
  }

  std::string check(const jobs::StoreTarget& target) const override { return target.output.string(); }

  jobs::OpenStore open(const jobs::StoreTarget& target) const override {
    database::ParquetOptions options{
        .geometry = geometry_, .overwrite = target.overwrite, .projjson = &geo::projjson_of};
    options.group_points = group_points_.value_or(options.group_points);
    return {target.output.parent_path(), [output = target.output, options](database::OrderedCloud& cloud,
                                                                           const Progress& progress) mutable {
              options.progress = progress;
              database::write_parquet(output, cloud, options);
            }};
  }

 private:
  bool geometry_ = false;
  std::optional<std::uint32_t> group_points_{};
};

}  // namespace

void set_up_parquet() {
  jobs::add_format(
      {.facts = {"Parquet", ".parquet", "", "write",
                 "for DuckDB, DataFusion, ...; --geometry adds GeoParquet 1.1"},
       .make_store = []() -> std::shared_ptr<jobs::CloudStore> { return std::make_shared<ParquetStore>(); }});
}

}  // namespace alidade::extensions
