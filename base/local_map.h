// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "base/input_file.h"

namespace alidade {

/// Maps the first `size` bytes of an open file on this machine into memory, read only; `name` is the file's
/// in messages. The system reads pages on first access; maps of one file share them. Of a file larger than
/// available_memory() it reads single pages: jumps through it would else push out needed pages by their
/// neighbours. Cost: constant. Errors: the file cannot be mapped.
///
/// If another program makes the file shorter, or its disk fails, there is nothing to be read any more. The
/// first access to a missing page then says so on stderr and ends the process with exit code 2, so that
/// callers need no check of their own. Outputs are not written; their temporary files stay, as those
/// of a killed process, until the next run removes them (base/output_file.h). Replacing the file by renaming,
/// as OutputFile does, leaves its maps as they were.
///
/// The first map of a process installs a handler for SIGBUS, also in programs that load the library, such as
/// Python. Signals for other memory go to the handler that was installed before. Limits: if a handler that is
/// installed later does not call this one, or a thread blocks SIGBUS, the signal ends the process without the
/// message. What another program writes into the file itself, or cuts off within its last page, is read as
/// it is: whoever replaces a file that may be in use writes another one and renames it.
MappedBytes map_file(const FileDescriptor& file, std::uint64_t size, const std::string& name);

/// Asks the system to begin reading some bytes of a map at once: for passes from front to back.
void expect_reads(std::span<const std::byte> bytes) noexcept;

}  // namespace alidade
