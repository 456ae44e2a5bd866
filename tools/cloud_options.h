// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

namespace alidade {

/// What the help text says about the files of a cloud, where there is nothing else to say.
inline constexpr const char* k_cloud_help =
    "cloud files, folders or patterns as 'tiles/*.las', taken together as one, an index file (.alidade), or "
    "a "
    "table of a database: site.db?table=NAME or postgresql://HOST/DATABASE?table=NAME";

/// What other help texts about them end with.
inline const std::string k_database_help =
    "; a table of a database, too: site.db?table=NAME or postgresql://HOST/DATABASE?table=NAME";

/// Declares the option, or the operand, that takes the files of a cloud; folders and patterns are expanded
/// (expand_cloud_files()) while the command line is read. Errors then: those of expand_cloud_files().
CLI::Option* add_cloud_files(CLI::App& command, const std::string& name,
                             std::vector<std::filesystem::path>& files, const std::string& help);

/// Declares --partial.
CLI::Option* add_partial(CLI::App& command, bool& partial);

}  // namespace alidade
