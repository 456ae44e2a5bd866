// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

namespace alidade {

/// Creates the temporary file that becomes an output, in its folder (temporary_beside()): empty, and locked
/// until its descriptor is closed, which must not be before it has the output's name. First removes what
/// killed processes left of this output: files that no process has locked, even if a process has the number
/// in their names. `name` is the output's in messages. Returns the descriptor. Errors: the folder is missing
/// or not writable.
int create_temporary(const std::filesystem::path& output, const std::string& name,
                     std::filesystem::path& temporary);

/// Waits until the bytes are on the disk. False if the system could not write them.
bool sync_temporary(int descriptor);

}  // namespace alidade
