// SPDX-License-Identifier: MIT
#include "jobs/cloud_formats.h"

#include <algorithm>

#include "database/sqlite/stored_cloud.h"
#include "octree/index_file/index_file.h"

namespace alidade::jobs {
namespace {

std::vector<AddedFormat>& formats() {
  static std::vector<AddedFormat> all = {{.facts = {"SQLite", "site.db?table=NAME", "3", "read, write",
                                                    "alidade sql load; chunks are read as needed"},
                                          .format = &database::k_sqlite_format,
                                          .part_unit = "chunks",
                                          .has_parts = [](const std::string&) { return true; },
                                          .read_part = database::read_cloud_part}};
  return all;
}

/// Null if the cloud is not of an added format.
const AddedFormat* format_of(const CloudInput& input) {
  const auto found = std::ranges::find(added_formats(), input.format, &AddedFormat::format);
  return input.format == nullptr || found == added_formats().end() ? nullptr : &*found;
}

}  // namespace

void add_format(const AddedFormat& format) {
  formats().push_back(format);
}

std::span<const AddedFormat> added_formats() {
  return formats();
}

CloudFormats cloud_formats() {
  static const std::vector<const CloudFormat*> all = [] {
    std::vector<const CloudFormat*> read;
    for (const AddedFormat& added : added_formats()) {
      if (added.format != nullptr) read.insert(read.begin(), added.format);
    }
    read.push_back(&k_index_format);
    read.insert(read.end(), file_formats().begin(), file_formats().end());
    return read;
  }();
  return all;
}

CloudStores make_stores() {
  CloudStores stores;
  for (const AddedFormat& added : added_formats()) {
    if (added.make_store != nullptr) stores.push_back(added.make_store());
  }
  return stores;
}

const CloudStore* store_of(const CloudStores& stores, const std::filesystem::path& output, bool is_file) {
  const auto found = std::ranges::find_if(
      stores, [&](const auto& store) { return store->is_file() == is_file && store->is_named(output); });
  return found == stores.end() ? nullptr : found->get();
}

const AddedFormat* server_of(const std::string& name) {
  const auto found = std::ranges::find_if(added_formats(), [&](const AddedFormat& added) {
    return added.shown != nullptr && added.format->is_named(name);
  });
  return found == added_formats().end() ? nullptr : &*found;
}

bool is_in_database(const CloudInput& input) {
  const AddedFormat* const added = format_of(input);
  return added != nullptr && added->read_part != nullptr;
}

bool has_parts(const CloudInput& input) {
  return is_in_database(input) && !input.is_changed() && format_of(input)->has_parts(input.name.string()) &&
         !input.changes_heights();
}

const char* part_unit(const CloudInput& input) {
  return format_of(input)->part_unit;
}

database::CloudPart read_database_part(const CloudInput& input, std::span<const database::PointFilter> any_of,
                                       AttributeSet attributes, const Progress& progress) {
  return format_of(input)->read_part(input.name.string(), any_of, attributes, progress);
}

}  // namespace alidade::jobs
