// SPDX-License-Identifier: MIT
#include "jobs/remote_files.h"

namespace alidade::jobs {
namespace {

RemoteAccess remote_access;
RemoteUser user_of_files;

}  // namespace

void set_remote_access(const RemoteAccess& access) {
  remote_access = access;
}

void add_remote_fields(const Fields& fields) {
  if (remote_access.add_fields != nullptr) remote_access.add_fields(fields);
}

RemoteTraffic remote_traffic() {
  return remote_access.traffic != nullptr ? remote_access.traffic() : RemoteTraffic();
}

void set_remote_user(const RemoteUser& user) {
  user_of_files = user;
}

const RemoteUser& remote_user() {
  return user_of_files;
}

}  // namespace alidade::jobs
