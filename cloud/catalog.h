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

/// Reads a catalog: the files of its items, in their order. Of each item it reads the href of the asset
/// "data", or else of the first asset whose roles contain "data", and the properties proj:bbox, pc:count and
/// pc:encoding. CloudInput::stated is set, unless proj:bbox or pc:count is missing or the box is flat (4
/// numbers). The format is that of the encoding, or of the type of the asset; null if it is unknown.
///
/// A relative href is resolved against the catalog's folder and must not leave it. An absolute one is an
/// http(s) URL of a file below that folder, or of an allowed host (base/allowed_hosts.h), and requests for it
/// are redirected to allowed hosts only. Everything else, such as "../a.laz", "/etc/a.laz", "file:" and
/// "s3:", is an Error, so that a catalog from elsewhere makes Alidade read only files below it.
///
/// Errors: the file is missing; it is not JSON, or not a collection of items; more than 2 GiB; an item
/// without a file, or whose file is a catalog; an invalid box or count. They name the item. Memory: the text,
/// and about 300 B per item. Cost: some 10 microseconds per item.
std::vector<CloudInput> read_catalog(const std::filesystem::path& catalog);

/// read_catalog() for the text of a catalog of this name.
std::vector<CloudInput> parse_catalog(std::string_view text, const std::string& name);

/// A name as an href: characters that a URL does not allow become %XX. Slashes stay.
std::string href_of(std::string_view name);

/// Checks an opened file against its catalog. Errors: another number of points than stated; a box (that of
/// its header) that exceeds the stated one. Passes if nothing is stated.
void check_stated(const CloudInput& input, std::optional<std::uint64_t> point_count,
                  const std::optional<Bounds>& box);

}  // namespace alidade
