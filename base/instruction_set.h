// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>
#include <vector>

namespace alidade {

/// Instruction sets that the traversal is compiled for. `best` = the widest of this machine.
enum class InstructionSet { best, scalar, sse4, avx2, avx512 };

/// The sets compiled in and usable on this machine, narrowest first; `scalar` is always one.
std::vector<InstructionSet> available_instruction_sets();

std::string_view name(InstructionSet instruction_set);

/// What `best` means here: the environment variable ALIDADE_INSTRUCTION_SET (a name as above) if set,
/// otherwise the widest available. Errors: the variable names a set that is unknown or not available.
InstructionSet best_instruction_set();

/// The set to use for a request: `best` becomes best_instruction_set(). Errors: not available on this
/// machine.
InstructionSet usable(InstructionSet requested);

}  // namespace alidade
