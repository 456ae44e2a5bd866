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

/// One way a cloud can be stored.
struct CloudFormat {
  std::string_view name;
  /// Whether a name is one of this format and not of a file; null: the format has no such names.
  bool (*is_named)(std::string_view name) = nullptr;
  /// By the first 4096 bytes of a file, or all it has; null: it is never a file.
  bool (*is_begun_by)(std::span<const std::byte> start) = nullptr;
  /// Errors: the content is not of this format. For names that are not of files the input is empty and has the
  /// name.
  std::unique_ptr<CloudReader> (*open)(InputFile input, Damage damage) = nullptr;
};

/// Formats, tested in this order.
using CloudFormats = std::span<const CloudFormat* const>;

extern const CloudFormat k_copc_format, k_las_format, k_e57_format, k_ply_format, k_pcd_format, k_ptx_format,
    k_text_format;

/// The formats above: LAS and LAZ, COPC, E57, PLY, PCD, PTX, PTS, CSV and XYZ. Text is the last: it takes
/// whatever is text.
CloudFormats file_formats();

/// Others, which are tested first, and file_formats().
std::vector<const CloudFormat*> with_file_formats(std::initializer_list<const CloudFormat*> first);

/// Where one cloud is stored. Nothing is open.
struct CloudInput {
  std::filesystem::path name;           ///< what messages call it
  const CloudFormat* format = nullptr;  ///< null: missing, unreadable, empty or unknown, as open_cloud() says
  std::optional<std::span<const std::byte>> memory{};  ///< the bytes of a file that is in memory
  /// What of it is wanted, and in which reference system (cloud/input_view.h); null: all as it is.
  std::shared_ptr<const InputView> view{};
  /// What a catalog says of it (cloud/catalog.h); null: nothing.
  std::shared_ptr<const StatedFile> stated{};

  /// Opens it. Errors: InputFile's.
  InputFile file() const;
  bool is(const CloudFormat& which) const { return format == &which; }
  /// Whether it is to be taken otherwise than it is stored, but for the unit of heights.
  bool is_changed() const;
  /// Whether its heights are to be in another unit (InputView::has_one_unit). Opens it. Requires a format. Errors:
  /// those of opening, and of InputView::change_of().
  bool changes_heights() const;
};

/// Files that are open at once, of many.
inline constexpr std::size_t k_most_files_at_once = 32;

/// Clouds that are taken together as one. Their order is that of the points.
struct CloudInputs {
  std::vector<CloudInput> inputs;

  bool empty() const { return inputs.empty(); }
  std::size_t size() const { return inputs.size(); }
  /// Requires one at least.
  const std::filesystem::path& first_name() const { return inputs.front().name; }
  std::vector<std::filesystem::path> names() const;
  /// "a.las", "a.las and 3 more".
  std::string title() const;
  /// The one that is of this format, the only one, and wanted as it is stored; else null.
  const CloudInput* only(const CloudFormat& format) const;
  /// Errors: the first file that cannot be opened.
  void check_files() const;
};

/// The clouds that names of files, folders and patterns expand to, in the order of the names, each tested once:
/// - a name of one of the formats (CloudFormat::is_named) is that cloud;
/// - a catalog (is_catalog_name()) is the files that it lists;
/// - another remote name (is_remote_name()) is one file;
/// - what is neither a folder nor a pattern is one file, whether it exists or not;
/// - a folder is the cloud files in it, not those of folders inside it: what ends in las, laz, ply, pcd, e57,
///   pts, ptx, xyz, txt or csv, in capitals or not;
/// - a pattern is what it matches: * any characters but '/', ? one character, [a-c] one of these, [!a-c] one
///   that is not, in the name of the file or of folders above it. If the name's last part has no '.', only
///   cloud files are taken, as from a folder. A last part that is not a pattern may be a folder: its files are
///   taken.
/// The name of an existing file or folder is never a pattern, whatever its characters are; nor are such names
/// of folders in a pattern. Hidden files (.name) and index files (.alidade) are left out unless named: by the
/// first characters, or the extension, of the pattern. Links are followed; a broken link is a file that cannot
/// be opened, so that its points are not missed silently. The files of one name are sorted by the bytes of
/// their paths; a file of two names is in the list twice.
///
/// Errors: a folder without cloud files or that cannot be read; a pattern that matches no file; those of
/// read_catalog(). Messages name
/// what was expected. A missing or damaged file is not an error here. Cost: reads each folder concerned once,
/// and the first bytes of each file whose format no catalog states, in parallel (oneTBB). `formats` must outlive the result.
CloudInputs resolve_clouds(std::span<const std::filesystem::path> names,
                           CloudFormats formats = file_formats());

/// A file in memory, called `name`. The bytes must outlive what is returned.
CloudInput cloud_in_memory(std::span<const std::byte> bytes, std::string name,
                           CloudFormats formats = file_formats());

}  // namespace alidade
