// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/bounds.h"
#include "cloud/cloud_inputs.h"

// Catalogs: GeoJSON files that list clouds as items of STAC 1.0 with the extensions "pointcloud" and
// "projection", so that files outside the region of interest need not be opened.

namespace alidade {

/// What a catalog states about a file before it is opened.
struct StatedFile {
  std::string catalog;            ///< its name, for messages
  Bounds box;                     ///< no point lies outside (proj:bbox, in the file's reference system)
  std::uint64_t point_count = 0;  ///< pc:count
};

/// Whether a name, up to a '?', ends in ".catalog.json" or ".catalog.json.gz".
bool is_catalog_name(std::string_view name);

/// Reads a catalog and returns the files of its items, in their order. The file of an item is the href of its
/// asset "data", or else of the first asset with the role "data". Its format follows from pc:encoding or the
/// type of the asset; null if neither names a known one. CloudInput::stated has proj:bbox and pc:count; it is
/// null if one of them is missing or the box has no heights (4 numbers).
///
/// Catalogs from elsewhere must not make Alidade read files outside of their folder. So a relative href is
/// resolved against the folder of the catalog and must not leave it. An absolute href is an http(s) URL of a
/// file in that folder, of one in a folder inside it, or of an allowed host (base/allowed_hosts.h); requests
/// for it follow redirects to allowed hosts only. All others, such as "../a.laz", "/etc/a.laz", "file:" and
/// "s3:", are errors.
///
/// Errors: the file is missing, larger than 2 GiB, not JSON, or not a collection of items; an item without a
/// file, or whose file is a catalog; an invalid box or count. Messages name the item. Memory: the text, and
/// about 300 B per item. Cost: some 10 microseconds per item.
std::vector<CloudInput> read_catalog(const std::filesystem::path& catalog);

/// read_catalog() for the text of a catalog of this name.
std::vector<CloudInput> parse_catalog(std::string_view text, const std::string& name);

/// A name as an href: characters that a URL does not allow become %XX. Slashes stay.
std::string href_of(std::string_view name);

/// Checks an opened file, whose header states `box`, against its catalog. Without CloudInput::stated there is
/// nothing to check. Errors: another number of points than stated; a box that exceeds the stated one.
void check_stated(const CloudInput& input, std::optional<std::uint64_t> point_count,
                  const std::optional<Bounds>& box);

}  // namespace alidade
