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

// Catalogs: GeoJSON files that list clouds as items of STAC 1.0 with the extensions "pointcloud" and "projection", so
// that files which cannot matter need not be opened.

namespace alidade {

/// What a catalog states of a file before it is opened.
struct StatedFile {
  std::string catalog;            ///< its name, for messages
  Bounds box;                     ///< no point lies outside (proj:bbox, in the file's reference system)
  std::uint64_t point_count = 0;  ///< pc:count
};

/// Whether a name, without what is behind a '?', ends in ".catalog.json" or ".catalog.json.gz".
bool is_catalog_name(std::string_view name);

/// Reads a catalog: the files of its items, in their order. Of each item count the asset "data", or else the first whose
/// roles hold "data"; its href, and of the properties proj:bbox, pc:count and pc:encoding. What a catalog states is
/// StatedFile, unless one of the first two is missing or the box is flat (4 numbers). The format is what the encoding,
/// or the type of the asset, says; null if that is nothing known.
///
/// A relative href is meant from the catalog's folder and stays in it. An absolute one is an http(s) URL: of a file below
/// that folder, or of a host that is allowed (base/allowed_hosts.h), and requests for it are redirected to none that is not.
/// Everything else, such as "../a.laz", "/etc/a.laz", "file:" and "s3:" is an Error, so that a catalog from elsewhere reads
/// nothing but what lies below it.
///
/// Errors: the file is missing; no JSON; no collection of items; more than 2 GiB; an item without file, or whose file is
/// a catalog; an invalid box or count. They name the item. Memory: the text, and about 300 B per
/// item. Cost: some 10 microseconds per item.
std::vector<CloudInput> read_catalog(const std::filesystem::path& catalog);

/// The same from the text of a catalog of this name.
std::vector<CloudInput> parse_catalog(std::string_view text, const std::string& name);

/// A name as an href: what a URL does not take as it is becomes %XX. Slashes stay.
std::string href_of(std::string_view name);

/// Errors: a file that was opened is not what the catalog states: another number of points, or a box (that of its
/// header) that reaches beyond. Passes if nothing is stated.
void check_stated(const CloudInput& input, std::optional<std::uint64_t> point_count,
                  const std::optional<Bounds>& box);

}  // namespace alidade
