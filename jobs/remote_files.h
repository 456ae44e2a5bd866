// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "jobs/fields.h"

// What jobs need of an extension that opens remote files (set_remote_files() in base/input_file.h), and what
// it needs to know of the program or of Python.

namespace alidade::jobs {

/// Requests and bytes of this process so far.
struct RemoteTraffic {
  std::uint64_t requests = 0;  ///< also those that were repeated
  std::uint64_t bytes = 0;     ///< of their contents
};

/// What is known of remote files beside how they are opened.
struct RemoteAccess {
  void (*add_fields)(const Fields& fields) = nullptr;
  RemoteTraffic (*traffic)() = nullptr;
};
/// Names it, before fields are declared.
void set_remote_access(const RemoteAccess& access);

/// Declares the fields of jobs that may read remote files: those of the extension, which hold for the
/// process.
void add_remote_fields(const Fields& fields);
RemoteTraffic remote_traffic();

/// Callbacks to the program or to Python while remote files are read. A missing `note` is ignored; a missing
/// `confirm` means no.
struct RemoteUser {
  bool (*is_interrupted)() = nullptr;  ///< called while waiting, by any thread; returns whether to stop
  void (*note)(const std::string& text) = nullptr;
  bool (*confirm)(const std::string& question) = nullptr;
};
/// Names the user, before files are opened.
void set_remote_user(const RemoteUser& user);
const RemoteUser& remote_user();

}  // namespace alidade::jobs
