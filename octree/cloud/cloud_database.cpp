// SPDX-License-Identifier: MIT
#include "octree/cloud/cloud_database.h"

#include <algorithm>

namespace alidade {
namespace {

std::vector<CloudDatabase>& databases() {
  static std::vector<CloudDatabase> all;
  return all;
}

template <class Condition>
const CloudDatabase* find(const Condition& condition) {
  const auto found = std::ranges::find_if(databases(), condition);
  return found == databases().end() ? nullptr : &*found;
}

}  // namespace

void add_cloud_database(const CloudDatabase& database) {
  databases().push_back(database);
}

const CloudDatabase* find_database_named(const std::string& name) {
  return find([&](const CloudDatabase& database) { return database.is_named(name); });
}

const CloudDatabase* find_database_begun_by(const std::string& bytes) {
  return find([&](const CloudDatabase& database) { return database.is_begun_by(bytes); });
}

InputFile cloud_input(const std::filesystem::path& name) {
  if (find_database_named(name.string()) != nullptr)
    return InputFile(std::span<const std::byte>(), name.string());
  return InputFile(name);
}

}  // namespace alidade
