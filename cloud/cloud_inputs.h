// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/input_file.h"
#include "cloud/damage.h"

namespace alidade {

class CloudReader;
struct InputView;
struct StatedFile;

/// A format of stored clouds.
struct CloudFormat {
  std::string_view name;
  /// Whether a name denotes a cloud of this format instead of a file; null: the format has no such names.
  bool (*is_named)(std::string_view name) = nullptr;
  /// Whether a file is of this format, by its first 4096 bytes, or all of a shorter one; null: no file is.
  bool (*is_begun_by)(std::span<const std::byte> start) = nullptr;
  /// Opens a cloud. For names that do not denote files, the input is empty and has the name. Errors: the
  /// content is not of this format.
  std::unique_ptr<CloudReader> (*open)(InputFile input, Damage damage) = nullptr;
};

/// Formats, tested in this order.
using CloudFormats = std::span<const CloudFormat* const>;

extern const CloudFormat k_copc_format, k_las_format, k_e57_format, k_ply_format, k_pcd_format, k_ptx_format,
    k_text_format;

/// The formats above: LAS and LAZ, COPC, E57, PLY, PCD, PTX, PTS, CSV and XYZ. Text is the last, as it
/// accepts any text.
CloudFormats file_formats();

/// The formats of `first`, which are tested first, and file_formats().
std::vector<const CloudFormat*> with_file_formats(std::initializer_list<const CloudFormat*> first);

/// One stored cloud, not open.
struct CloudInput {
  std::filesystem::path name;           ///< in messages
  const CloudFormat* format = nullptr;  ///< null: missing, unreadable, empty or unknown, see open_cloud()
  std::optional<std::span<const std::byte>> memory{};  ///< the bytes of a file that is in memory
  /// Selects its points and their reference system (cloud/input_view.h); null: all points, unchanged.
  std::shared_ptr<const InputView> view{};
  /// What a catalog states about it (cloud/catalog.h); null: nothing.
  std::shared_ptr<const StatedFile> stated{};

  /// Opens the file. Errors: as InputFile.
  InputFile file() const;
  bool is(const CloudFormat& which) const { return format == &which; }
  /// Whether its view selects or moves points; the unit of heights does not count.
  bool is_changed() const;
  /// Whether its heights are wanted in another unit (InputView::has_one_unit). Opens the cloud. Requires a
  /// format. Errors: those of open_cloud() and of InputView::change_of().
  bool changes_heights() const;
};

/// Most files of a large set that are open at once.
inline constexpr std::size_t k_most_files_at_once = 32;

/// Clouds that are read as one. Their order is that of the points.
struct CloudInputs {
  std::vector<CloudInput> inputs;

  bool empty() const { return inputs.empty(); }
  std::size_t size() const { return inputs.size(); }
  /// Requires at least one input.
  const std::filesystem::path& first_name() const { return inputs.front().name; }
  std::vector<std::filesystem::path> names() const;
  /// "a.las", "a.las and 3 more".
  std::string title() const;
  /// The only input, if it is of this format and wanted as it is stored; else null.
  const CloudInput* only(const CloudFormat& format) const;
  /// Checks that all files can be opened. Errors: the first file that cannot.
  void check_files() const;
};

/// The clouds that names of files, folders and patterns expand to, in the order of the names:
/// - a name of one of the formats (CloudFormat::is_named) is that cloud;
/// - a catalog (is_catalog_name()) is the files that it lists;
/// - another remote name (is_remote_name()) is one file;
/// - a name that is neither a folder nor a pattern is one file, whether it exists or not;
/// - a folder is the cloud files in it, not those of folders inside it: names that end in las, laz, ply, pcd,
///   e57, pts, ptx, xyz, txt or csv, in upper or lower case;
/// - a pattern is the names that it matches: * any characters but '/', ? one character, [a-c] one of these,
///   [!a-c] one that is not, in the name of the file or of folders above it. If the pattern's last part has
///   no '.', only cloud files are taken, as from a folder. A last part that is not a pattern may be a folder:
///   its files are taken.
/// The name of an existing file or folder is never a pattern, whatever its characters are; nor are such names
/// of folders in a pattern. Hidden files (.name) and index files (.alidade) are left out unless named: by the
/// first characters, or the extension, of the pattern. Links are followed; a broken link is a file that
/// cannot be opened, so that its points are not missed silently. The files of one name are sorted by the
/// bytes of their paths; a file that two names expand to is in the list twice.
///
/// Errors: a folder that has no cloud files or cannot be read; a pattern that matches no file; those of
/// read_catalog(). A missing or damaged file is not an error here. Cost: reads each folder once, and the
/// first bytes of each file whose format no catalog states, in parallel (oneTBB). `formats` must outlive the
/// result.
CloudInputs resolve_clouds(std::span<const std::filesystem::path> names,
                           CloudFormats formats = file_formats());

/// A file in memory, called `name`. The bytes must outlive the result.
CloudInput cloud_in_memory(std::span<const std::byte> bytes, std::string name,
                           CloudFormats formats = file_formats());

}  // namespace alidade
