// SPDX-License-Identifier: MIT
#include "cloud/cloud_inputs.h"

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

bool lies_in_database(const std::filesystem::path& name) {
  if (find_database_named(name.string()) != nullptr) return true;
  std::error_code error;
  if (!std::filesystem::is_regular_file(name, error)) return false;
  constexpr std::size_t k_looked_at = 16;
  InputFile file(name);
  const std::span<const std::byte> bytes = file.view_up_to(0, k_looked_at);
  return find_database_begun_by({reinterpret_cast<const char*>(bytes.data()), bytes.size()}) != nullptr;
}

InputFile cloud_input(const std::filesystem::path& name) {
  if (find_database_named(name.string()) != nullptr)
    return InputFile(std::span<const std::byte>(), name.string());
  return InputFile(name);
}

}  // namespace alidade
