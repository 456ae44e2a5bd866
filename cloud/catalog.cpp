// SPDX-License-Identifier: MIT
#include "cloud/catalog.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/allowed_hosts.h"
#include "base/error.h"
#include "base/input_file.h"
#include "base/json.h"
#include "base/words.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::uint64_t k_largest_catalog = std::uint64_t{2} << 30;
constexpr int k_deepest_nesting = 64;
constexpr double k_largest_coordinate = 1e12;
constexpr std::uint64_t k_most_listed_points = std::uint64_t{1} << 62;  // of all items
constexpr std::array<std::string_view, 1> k_items = {"features"};
constexpr const char* k_remedy = "make the catalog again with 'alidade catalog'";

std::string_view without_query(std::string_view name) {
  return name.substr(0, name.find('?'));
}

bool is_web_url(std::string_view name) {
  return name.starts_with("https://") || name.starts_with("http://");
}

/// The path of a URL, without parameters.
std::string_view path_of(std::string_view url) {
  url = without_query(url.substr(0, url.find('#')));
  return url.substr(std::min(url.find('/', url.find("://") + 3), url.size()));
}

/// Text with its %XX replaced; empty if one is invalid or means a control character.
std::optional<std::string> decoded(std::string_view text) {
  std::optional<std::string> plain = percent_decoded(text);
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  if (plain && std::ranges::any_of(*plain, is_control)) plain.reset();
  return plain;
}

/// Whether a path from a folder never leaves it, and names something in it.
bool stays_inside(std::string_view path) {
  int depth = 0;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    const std::string_view part = path.substr(begin, end - begin);
    depth += part == ".." ? -1 : part.empty() || part == "." ? 0 : 1;
    if (depth < 0) return false;
    begin = end + 1;
  }
  return depth > 0;
}

/// Reads the items of one catalog.
class CatalogReader {
 public:
  explicit CatalogReader(std::string name) : name_(std::move(name)) {}

  std::vector<CloudInput> read(std::string_view text) {
    // Items are read one by one: all of them would need ten times the memory of their text.
    bool is_feature = false;
    const auto take = [&](int depth, Json::parse_event_t event, Json& value) {
      if (depth > k_deepest_nesting)
        fail("nested too deep", fmt::format("at most {} levels", k_deepest_nesting));
      if (event == Json::parse_event_t::key && depth == 1) is_feature = value == "features";
      if (event == Json::parse_event_t::key && depth > 1)
        return !is_unread(value.get_ref<const std::string&>());
      if (event != Json::parse_event_t::object_end || depth != 2 || !is_feature) return true;
      add(value);
      return false;
    };
    Json root;
    try {
      root = Json::parse(text, take);
    } catch (const Json::exception&) {
      // Throws an Error with line and column; keeps nothing of the items.
      parse_json(std::string(text), name_, k_items);
      fail("invalid JSON");
    }
    const auto features = root.is_object() ? root.find("features") : root.end();
    if (features == root.end() || !features->is_array() || root.value("type", Json()) != "FeatureCollection")
      fail("not a catalog", "a GeoJSON FeatureCollection of STAC items (alidade catalog)");
    if (!features->empty()) fail("an item is no object", "STAC items");
    if (inputs_.empty()) fail("the catalog lists no files", "one item at least");
    return std::move(inputs_);
  }

 private:
  static bool is_unread(const std::string& key) {
    static constexpr std::array<std::string_view, 5> k_large = {"geometry", "links", "pc:schemas",
                                                                "proj:wkt2", "proj:projjson"};
    return std::ranges::find(k_large, key) != k_large.end();
  }

  [[noreturn]] void fail(std::string problem, std::string expected = {}, std::string found = {}) const {
    throw Error(name_, {}, std::move(problem), std::move(expected), std::move(found));
  }

  [[noreturn]] void fail_item(std::string problem, std::string expected, std::string found = {}) const {
    throw Error(name_, fmt::format("item {}", inputs_.size() + 1), std::move(problem), std::move(expected),
                std::move(found));
  }

  void add(const Json& item) {
    static const Json k_nothing;
    const auto member = [](const Json& object, const char* key) -> const Json& {
      const auto found = object.is_object() ? object.find(key) : object.end();
      return found == object.end() ? k_nothing : *found;
    };
    const Json& asset = data_asset(member(item, "assets"));
    const Json& href = member(asset, "href");
    if (!href.is_string()) fail_item("the item has no file", "an asset 'data' with an href");
    const Json& properties = member(item, "properties");
    CloudInput input{.name = file_of(href.get_ref<const std::string&>())};
    input.format = format_of(member(properties, "pc:encoding"), member(asset, "type"), input.name.string());
    input.stated = stated(member(properties, "proj:bbox"), member(properties, "pc:count"));
    inputs_.push_back(std::move(input));
  }

  static const Json& data_asset(const Json& assets) {
    static const Json k_nothing;
    if (!assets.is_object()) return k_nothing;
    if (const auto data = assets.find("data"); data != assets.end()) return *data;
    for (const Json& asset : assets) {
      const auto roles = asset.is_object() ? asset.find("roles") : asset.end();
      if (roles != asset.end() && roles->is_array() &&
          std::ranges::find(*roles, Json("data")) != roles->end())
        return asset;
    }
    return k_nothing;
  }

  fs::path file_of(const std::string& href) const {
    constexpr std::size_t k_longest = 4096;
    if (href.size() > k_longest) fail_item("the href is too long", "at most 4096 bytes");
    std::string file;
    if (is_web_url(href)) {
      const std::string host = host_of(href);
      if (!decoded(href) || host.empty()) fail_item("invalid href", "a URL", quote(href));
      if (!lies_below(href) && std::ranges::count(allowed_hosts(), host) == 0)
        fail_item(
            "the href leads to " + host + ", which is not allowed",
            fmt::format("files below the catalog, or --allow-host {0} (or ALIDADE_ALLOW_HOSTS={0} in the "
                        "environment)",
                        host),
            quote(href));
      file = href;
    } else {
      const auto plain = decoded(without_query(href));
      const bool has_scheme = href.find(':') < href.find('/');
      if (!plain || has_scheme || plain->starts_with('/') || !stays_inside(*plain))
        fail_item("the href leaves the catalog's folder",
                  "a relative path without '..', or the URL of a host that --allow-host names", quote(href));
      const std::string_view folder = without_query(name_);
      const std::string base(folder.substr(0, folder.rfind('/') + 1));
      file = base + (is_web_url(name_) ? href : *plain);
    }
    if (is_catalog_name(file)) fail_item("the catalog lists a catalog", "files of points", quote(href));
    if (is_remote_name(file)) note_listed_file(file);
    return file;
  }

  /// Whether a URL is that of a file below the folder of the catalog, on the catalog's server.
  bool lies_below(std::string_view url) const {
    const auto scheme_of = [](std::string_view of) { return lower_case(of.substr(0, of.find(':'))); };
    if (!is_web_url(name_) || scheme_of(url) != scheme_of(name_) || host_of(url) != host_of(name_))
      return false;
    const std::string_view catalog = path_of(name_);
    const auto folder = decoded(catalog.substr(0, catalog.rfind('/') + 1)), path = decoded(path_of(url));
    return folder && path && path->starts_with(*folder) && stays_inside(path->substr(folder->size()));
  }

  static const CloudFormat* format_of(const Json& encoding, const Json& type, const std::string& file) {
    const std::string name = encoding.is_string() ? lower_case(encoding.get_ref<const std::string&>()) : "";
    if (type == "application/vnd.laszip+copc" || lower_case(without_query(file)).ends_with(".copc.laz"))
      return &k_copc_format;
    if (name == "laz" || name == "laszip") return &k_las_format;
    for (const CloudFormat* const format : file_formats())
      if (lower_case(format->name) == name) return format;
    return nullptr;
  }

  std::shared_ptr<const StatedFile> stated(const Json& box, const Json& count) {
    if (box.is_null() || count.is_null()) return nullptr;
    if (!count.is_number_unsigned())
      fail_item("invalid pc:count", "a number of points", count.dump().substr(0, 40));
    StatedFile stated{.catalog = name_, .box = {}, .point_count = count.get<std::uint64_t>()};
    if (stated.point_count > k_most_listed_points - points_)
      fail_item("pc:count is too large", fmt::format("at most {} points in all", k_most_listed_points),
                std::to_string(stated.point_count));
    points_ += stated.point_count;
    if (!box.is_array() || (box.size() != 6 && box.size() != 4))
      fail_item("invalid proj:bbox", "6 numbers", box.dump().substr(0, 40));
    for (const Json& number : box) {
      if (!number.is_number() || !(std::fabs(number.get<double>()) <= k_largest_coordinate))
        fail_item("invalid proj:bbox", "numbers up to 1e12", number.dump().substr(0, 40));
    }
    if (box.size() == 4) return nullptr;
    for (int axis = 0; axis < 3; ++axis) {
      stated.box.min[axis] = box[static_cast<std::size_t>(axis)].get<double>();
      stated.box.max[axis] = box[static_cast<std::size_t>(axis) + 3].get<double>();
    }
    if (stated.box.empty())
      fail_item("invalid proj:bbox", "the lower limits first", box.dump().substr(0, 80));
    return std::make_shared<const StatedFile>(std::move(stated));
  }

  std::string name_;
  std::vector<CloudInput> inputs_;
  std::uint64_t points_ = 0;  ///< of all items so far
};

std::string text_of(const Bounds& box) {
  return fmt::format("{}, {}, {} to {}, {}, {}", box.min.x, box.min.y, box.min.z, box.max.x, box.max.y,
                     box.max.z);
}

}  // namespace

bool is_catalog_name(std::string_view name) {
  const std::string small = lower_case(without_query(name));
  return small.ends_with(".catalog.json") || small.ends_with(".catalog.json.gz");
}

std::vector<CloudInput> read_catalog(const fs::path& catalog) {
  const std::string name = catalog.string();
  const bool is_packed = without_query(name).ends_with(".gz");
  std::error_code error;
  InputFile file(is_packed && !is_remote_name(name) ? "/vsigzip/" + fs::absolute(name, error).string()
                                                    : name);
  if (file.size() > k_largest_catalog)
    throw file_error(name, "the catalog is too large", fmt::format("at most {} bytes", k_largest_catalog),
                     std::to_string(file.size()));
  std::string text(static_cast<std::size_t>(file.size()), '\0');
  file.read_at(0, std::as_writable_bytes(std::span(text)));
  return parse_catalog(text, name);
}

std::vector<CloudInput> parse_catalog(std::string_view text, const std::string& name) {
  return CatalogReader(name).read(text);
}

std::string href_of(std::string_view name) {
  // Source: RFC 3986, unreserved characters.
  constexpr std::string_view k_plain = "-._~/";
  std::string href;
  for (const char character : name) {
    const auto byte = static_cast<unsigned char>(character);
    const bool is_plain = byte < 0x80 && (std::isalnum(byte) != 0 || k_plain.find(character) != k_plain.npos);
    href += is_plain ? std::string(1, character) : fmt::format("%{:02X}", byte);
  }
  return href;
}

void check_stated(const CloudInput& input, std::optional<std::uint64_t> point_count,
                  const std::optional<Bounds>& box) {
  if (!input.stated) return;
  const StatedFile& stated = *input.stated;
  const auto fail = [&](const char* what, std::string expected, std::string found) {
    throw Error({.file = input.name.string(),
                 .problem = fmt::format("{} states another {}: {}", stated.catalog, what, k_remedy),
                 .expected = std::move(expected),
                 .found = std::move(found)});
  };
  if (point_count && *point_count != stated.point_count)
    fail("number of points", std::to_string(stated.point_count), std::to_string(*point_count));
  if (box && !(stated.box.contains(box->min) && stated.box.contains(box->max)))
    fail("box", text_of(stated.box), text_of(*box));
}

}  // namespace alidade
