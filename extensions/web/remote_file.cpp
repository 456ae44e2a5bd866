// SPDX-License-Identifier: MIT
#include "extensions/web/remote_file.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <string_view>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "base/error.h"
#include "base/local_map.h"
#include "base/recently_used.h"
#include "base/scratch_file.h"
#include "base/shown_text.h"
#include "extensions/web/block_folder.h"
#include "extensions/web/http_source.h"
#include "geo/gdal_reference.h"

namespace alidade::geo {
namespace {

/// The name of a virtual file of GDAL.
std::string virtual_name(const std::string& name) {
  constexpr std::array<std::pair<const char*, const char*>, 3> k_buckets = {
      {{"s3://", "/vsis3/"}, {"gs://", "/vsigs/"}, {"az://", "/vsiaz/"}}};
  for (const auto& [begin, folder] : k_buckets)
    if (name.starts_with(begin)) return folder + name.substr(std::string(begin).size());
  return name;
}

/// The URL of a file that HttpSource reads; empty for others.
std::string web_url(std::string_view name) {
  constexpr std::string_view k_virtual = "/vsicurl/";
  if (name.starts_with(k_virtual)) name.remove_prefix(k_virtual.size());
  return name.starts_with("http://") || name.starts_with("https://") ? std::string(name) : "";
}

/// Whether a name is that of a compressed catalog, which is decompressed.
bool is_packed(const std::string& name) {
  return name.substr(0, name.find('?')).ends_with(".json.gz") && !name.starts_with("/vsigzip/");
}

/// The time of modification, as a part of a version; empty if it is unknown. A compressed file has the
/// time of the packed file: GDAL gives the time of a compressed file only for the one that it opened last,
/// and 0 for others.
std::string time_of(std::string_view path) {
  constexpr std::string_view k_packed = "/vsigzip/";
  while (path.starts_with(k_packed)) path.remove_prefix(k_packed.size());
  // GDAL caches it for files that were opened: no request.
  VSIStatBufL status{};
  const bool is_known = VSIStatExL(std::string(path).c_str(), &status, VSI_STAT_SIZE_FLAG) == 0;
  return is_known ? fmt::format(" {}", status.st_mtime) : "";
}

std::string gdal_reason() {
  const std::string reason = VSIGetLastErrorMsg();
  return reason.empty() ? CPLGetLastErrorMsg() : reason;
}

[[noreturn]] void fail(const std::string& name, const char* problem, std::string expected = "") {
  std::string reason = gdal_reason();
  reason.resize(std::min(reason.size(), reason.find('\n')));  // a page of a server
  throw Error({.file = name,
               .problem = problem + (reason.empty() ? "" : ": " + reason),
               .expected = std::move(expected)});
}

[[noreturn]] void fail_to_open(const std::string& name) {
  constexpr std::array k_refused = {VSIE_AWSAccessDenied, VSIE_AWSBucketNotFound, VSIE_AWSObjectNotFound};
  const std::string reason = gdal_reason();
  static const std::regex status("response code.*: 40[34]\\b");
  const bool is_refused = std::ranges::find(k_refused, VSIGetLastErrorNo()) != k_refused.end() ||
                          std::regex_search(reason, status);
  fail(name, "cannot open the file",
       reason.empty() || is_refused ? "an existing file that you may read" : "");
}

/// Sets the options of GDAL that the environment does not set.
void set_defaults() {
  constexpr std::array<std::pair<const char*, const char*>, 8> k_defaults = {{
      {"GDAL_HTTP_MAX_RETRY", "3"},
      {"GDAL_HTTP_RETRY_DELAY", "1"},
      {"GDAL_HTTP_CONNECTTIMEOUT", "30"},
      {"GDAL_HTTP_LOW_SPEED_TIME", "30"},
      {"GDAL_HTTP_LOW_SPEED_LIMIT", "4000"},  // bytes a second
      {"CPL_VSIL_CURL_CACHE_SIZE", "67108864"},
      {"CPL_VSIL_NETWORK_STATS_ENABLED", "YES"},
      {"CPL_VSIL_GZIP_WRITE_PROPERTIES", "NO"},
  }};
  for (const auto& [option, value] : k_defaults)
    if (CPLGetConfigOption(option, nullptr) == nullptr) CPLSetConfigOption(option, value);
}

constexpr std::size_t k_block = 16 << 10;

/// Blocks of files on web servers, the latest 64 MiB of all. Thread safe.
class BlockMemory {
 public:
  using Block = std::shared_ptr<const std::vector<std::byte>>;
  using Key = std::pair<std::uint64_t, std::uint64_t>;  ///< number of the source, block

  Block find(const Key& key) {
    const std::scoped_lock lock(mutex_);
    const Block* const block = blocks_.find(key);
    return block != nullptr ? *block : nullptr;
  }

  void keep(const Key& key, Block block) {
    constexpr std::size_t k_most_blocks = (std::size_t{64} << 20) / k_block;
    const std::scoped_lock lock(mutex_);
    if (blocks_.find(key) != nullptr) return;
    blocks_.add(key, std::move(block));
    if (blocks_.size() > k_most_blocks) blocks_.take_oldest();
  }

 private:
  struct KeyHash {
    std::size_t operator()(const Key& key) const {
      return std::hash<std::uint64_t>()(key.first << 40 ^ key.second);
    }
  };

  std::mutex mutex_;
  RecentlyUsed<Key, Block, KeyHash> blocks_;
};

/// The process's files on web servers and their blocks. Never destroyed: other static objects may read files.
struct Web {
  explicit Web(const RemoteOptions& chosen) : options(chosen) {
    if (!options.cache.empty()) folder.emplace(options.cache, options.cache_bytes);
  }

  const RemoteOptions options;
  std::mutex mutex;
  std::map<std::string, std::shared_ptr<HttpSource>> sources;  ///< by URL
  BlockMemory memory;
  std::optional<BlockFolder> folder;
};

Web& web(const RemoteOptions& options = {}) {
  static Web& web = *new Web(options);
  return web;
}

bool is_stopped() {
  return web().options.is_interrupted != nullptr && web().options.is_interrupted();
}

/// A file that is to be fetched whole.
struct WantedFile {
  std::string name;  ///< in messages
  std::string key;   ///< of it and its version in the cache; empty: it has no version
  std::uint64_t size;
  std::function<void(std::uint64_t offset, std::span<std::byte> into)> read;
  const std::function<void(const WholeFetch&)>& permit;
};

void check_room(const WholeFetch& fetch) {
  std::error_code error;
  const std::uintmax_t room = std::filesystem::space(fetch.folder, error).available;
  if (error || room >= fetch.bytes) return;
  const auto text = [](std::uint64_t bytes) { return quantity(static_cast<double>(bytes), "B"); };
  throw file_error(fetch.name, "no room for the file in " + fetch.folder.string(),
                   text(fetch.bytes) + ", or another folder: " + (fetch.is_kept ? "--cache" : "TMPDIR"),
                   text(room) + " free");
}

WholeFetch into_temporary(const WantedFile& file) {
  WholeFetch fetch{.name = file.name, .bytes = file.size, .folder = temporary_folder()};
  fetch.keeping = file.key.empty() ? "not kept: only web servers that state its version allow that"
                  : web().folder   ? "a larger --cache-size keeps it for the next time"
                                   : "--cache FOLDER keeps it for the next time";
  return fetch;
}

MappedBytes fetch_whole(const WantedFile& file, const Progress& progress) {
  constexpr std::uint64_t k_piece = std::uint64_t{8} << 20;
  BlockFolder* const folder = web().folder && !file.key.empty() ? &*web().folder : nullptr;
  WholeFetch fetch = into_temporary(file);
  if (folder != nullptr && folder->has_room(file.size, k_block)) {
    fetch.bytes -= folder->fetched_of(file.key, file.size);
    fetch.folder = web().options.cache;
    fetch.is_kept = true;
    fetch.keeping = "kept for the next time";
  }
  if (fetch.bytes > 0 && file.permit) file.permit(fetch);
  if (fetch.bytes > 0) check_room(fetch);
  std::optional<KeptCopy> kept;
  if (fetch.is_kept) kept = folder->copy_of(file.key, file.size);
  // Another process may be fetching it into the cache.
  if (fetch.is_kept && !kept) check_room(into_temporary(file));
  const auto scratch = kept ? nullptr : std::make_shared<ScratchFile>(temporary_folder());
  std::vector<std::byte> bytes;
  for (std::uint64_t done = kept ? kept->fetched : 0; done < file.size; done += bytes.size()) {
    if (is_stopped()) throw Cancelled();
    report(progress, done, file.size);
    bytes.resize(static_cast<std::size_t>(std::min(k_piece, file.size - done)));
    file.read(done, bytes);
    kept ? folder->extend(*kept, file.key, file.size, bytes) : scratch->append(bytes);
  }
  report(progress, file.size, file.size);
  if (kept) return map_file(kept->file, file.size, file.name);
  const std::span<const std::byte> mapped = scratch->map();
  return {mapped, scratch};
}

class VirtualFile final : public RemoteFile {
 public:
  /// `name` is the file's in messages.
  VirtualFile(const std::string& name, const std::string& path,
              std::function<void(const WholeFetch&)> permit = {})
      : name_(name), permit_(std::move(permit)) {
    const QuietGdal quiet;
    VSIErrorReset();
    std::string time;
    {
      // Does not list the other files of its folder.
      const GdalOption list("GDAL_DISABLE_READDIR_ON_OPEN", "EMPTY_DIR");
      handle_.reset(VSIFOpenExL(path.c_str(), "rb", TRUE));
      if (handle_) time = time_of(path);
    }
    if (!handle_) {
      VSICurlPartialClearCache(path.c_str());  // where GDAL remembers failures, it does so without the reason
      fail_to_open(name);
    }
    if (VSIFSeekL(handle_.get(), 0, SEEK_END) != 0) fail(name_, "cannot measure the file");
    size_ = VSIFTellL(handle_.get());
    version_ = std::to_string(size_) + time;
  }

  std::uint64_t size() const override { return size_; }
  std::string version() const override { return version_; }

  void read(std::uint64_t offset, std::span<std::byte> into) override {
    const QuietGdal quiet;
    VSIErrorReset();
    if (VSIFSeekL(handle_.get(), offset, SEEK_SET) != 0 ||
        VSIFReadL(into.data(), 1, into.size(), handle_.get()) != into.size())
      fail(name_, "cannot read the file");
  }

  MappedBytes map(const Progress& progress) override {
    const auto read_range = [&](std::uint64_t offset, std::span<std::byte> into) { read(offset, into); };
    return fetch_whole({name_, "", size_, read_range, permit_}, progress);
  }

 private:
  std::string name_, version_;
  std::function<void(const WholeFetch&)> permit_;
  GdalHandle<VSIFCloseL, VSILFILE> handle_;
  std::uint64_t size_ = 0;
};

/// A compressed file, fetched at once: unpacking as it comes would take more requests.
class UnpackedFile final : public RemoteFile {
 public:
  UnpackedFile(const std::string& name, RemoteFile& packed)
      // Numbered, since GDAL caches the contents of files by name.
      : packed_(fmt::format("_{}.gz", count_++).c_str()) {
    constexpr std::uint64_t k_largest = std::uint64_t{256} << 20;
    if (packed.size() > k_largest)
      throw Error({.file = name,
                   .problem = "the compressed catalog is too large",
                   .expected = std::to_string(k_largest) + " bytes",
                   .found = std::to_string(packed.size())});
    std::vector<std::byte> bytes(static_cast<std::size_t>(packed.size()));
    if (!bytes.empty()) packed.read(0, bytes);
    VSILFILE* const file = VSIFOpenL(packed_.name(), "wb");
    const bool is_kept = file != nullptr && VSIFWriteL(bytes.data(), 1, bytes.size(), file) == bytes.size();
    if (file != nullptr) VSIFCloseL(file);
    if (!is_kept) fail(name, "cannot keep the file in memory");
    version_ = packed.version();
    content_.emplace(name, std::string("/vsigzip/") + packed_.name());
  }

  std::uint64_t size() const override { return content_->size(); }
  std::string version() const override { return version_; }
  void read(std::uint64_t offset, std::span<std::byte> into) override { content_->read(offset, into); }
  MappedBytes map(const Progress& progress) override { return content_->map(progress); }

 private:
  static inline std::atomic<int> count_ = 0;
  GdalMemoryFile packed_;
  std::string version_;
  std::optional<VirtualFile> content_{};
};

std::string block_key(const HttpSource& source, const std::string& url, std::uint64_t block) {
  return url + "\n" + source.version() + "\n" + std::to_string(block);
}

/// Puts all blocks of a file into the folder; false if it has no version, or the folder no room for it.
bool keep_whole(HttpSource& source, const std::string& url) {
  if (source.version().empty() || !web().folder->has_room(source.size(), k_block)) return false;
  std::vector<std::byte> bytes;
  for (std::uint64_t begin = 0; begin < source.size(); begin += bytes.size()) {
    if (is_stopped()) throw Cancelled();
    bytes.resize(static_cast<std::size_t>(std::min<std::uint64_t>(k_block, source.size() - begin)));
    source.read(begin, bytes);
    web().folder->keep(block_key(source, url, begin / k_block), bytes);
  }
  return true;
}

/// The source of a URL, opened once in a process and again when it turns out that the file changed.
std::shared_ptr<HttpSource> http_source(const std::string& name, const std::string& url,
                                        const std::optional<std::vector<std::string>>& hosts) {
  {
    const std::scoped_lock lock(web().mutex);
    const auto known = web().sources.find(url);
    if (known != web().sources.end() && !known->second->has_changed()) return known->second;
  }
  // A server without ranges sends the whole file as the first bytes. The folder holds the version in the
  // mark.
  const std::string mark = url + "\nno ranges";
  std::optional<std::uint64_t> marked;
  if (web().folder)
    if (const auto kept = web().folder->find(mark, sizeof(*marked)))
      marked = load<std::uint64_t>(kept->data());
  auto source = std::make_shared<HttpSource>(name, url, k_block, web().options.is_interrupted, hosts, marked);
  if (auto start = source->take_start(); !start.empty())
    web().memory.keep({source->number(), 0},
                      std::make_shared<const std::vector<std::byte>>(std::move(start)));
  if (web().folder && source->has_whole() && keep_whole(*source, url)) {
    const std::array sum = {source->sum_of_version()};
    web().folder->keep(mark, std::as_bytes(std::span(sum)));
  }
  const std::scoped_lock lock(web().mutex);
  std::shared_ptr<HttpSource>& known = web().sources[url];
  if (known && !known->has_changed()) return known;  // another thread was faster
  known = source;
  return source;
}

/// A file on a web server, read in whole blocks, which are kept.
class HttpFile final : public RemoteFile {
 public:
  HttpFile(std::shared_ptr<HttpSource> source, const std::string& url, std::string name,
           std::function<void(const WholeFetch&)> permit)
      : source_(std::move(source)), url_(url), name_(std::move(name)), permit_(std::move(permit)) {
    if (!source_->version().empty() && web().folder) folder_ = &*web().folder;
  }

  std::uint64_t size() const override { return source_->size(); }
  std::string version() const override { return source_->version(); }

  void read(std::uint64_t offset, std::span<std::byte> into) override {
    look_ahead(offset, into.size());
    // So much for each request, so that little is lost when one fails.
    constexpr std::uint64_t k_most = std::uint64_t{16} << 20;
    const std::uint64_t end = offset + into.size();
    for (std::uint64_t at = offset; at < end;) {
      const std::uint64_t block = at / k_block;
      const BlockMemory::Block kept = find(block);
      const std::uint64_t from = block * k_block;
      std::vector<std::byte> fetched;
      if (!kept) fetched = fetch(block, std::min(end, from + k_most));
      const std::vector<std::byte>& bytes = kept ? *kept : fetched;
      const std::uint64_t count = std::min(end, from + bytes.size()) - at;
      std::memcpy(into.data() + (at - offset), bytes.data() + (at - from), count);
      at += count;
    }
  }

  MappedBytes map(const Progress& progress) override {
    const auto read_range = [&](std::uint64_t offset, std::span<std::byte> into) {
      source_->read(offset, into);
    };
    const std::string key = version().empty() ? "" : url_ + "\n" + version();
    return fetch_whole({name_, key, size(), read_range, permit_}, progress);
  }

 private:
  std::uint64_t block_count() const { return (size() + k_block - 1) / k_block; }
  std::string key_of(std::uint64_t block) const { return block_key(*source_, url_, block); }

  /// Sequential reads fetch more and more at once.
  void look_ahead(std::uint64_t offset, std::uint64_t count) {
    constexpr std::uint64_t k_least = 64 << 10, k_most = 4 << 20;
    ahead_ = offset != 0 && offset == next_ ? std::clamp(2 * ahead_, k_least, k_most) : 0;
    next_ = offset + count;
  }

  BlockMemory::Block find(std::uint64_t block) const {
    const std::uint64_t count = std::min<std::uint64_t>(k_block, size() - block * k_block);
    auto known = web().memory.find({source_->number(), block});
    if (known && known->size() == count) return known;
    if (folder_ == nullptr) return nullptr;
    auto stored = folder_->find(key_of(block), static_cast<std::size_t>(count));
    if (!stored) return nullptr;
    auto kept = std::make_shared<const std::vector<std::byte>>(std::move(*stored));
    web().memory.keep({source_->number(), block}, kept);
    return kept;
  }

  bool is_kept(std::uint64_t block) const {
    return web().memory.find({source_->number(), block}) ||
           (folder_ != nullptr && folder_->contains(key_of(block)));
  }

  /// The blocks from `first` on that are not kept, until those that hold all before `end`.
  std::vector<std::byte> fetch(std::uint64_t first, std::uint64_t end) {
    const std::uint64_t needed = (end + k_block - 1) / k_block;
    const std::uint64_t limit = std::min(block_count(), needed + (end == next_ ? ahead_ / k_block : 0));
    std::uint64_t last = first + 1;
    while (last < limit && !is_kept(last)) ++last;
    std::vector<std::byte> bytes(
        static_cast<std::size_t>(std::min(size(), last * k_block) - first * k_block));
    source_->read(first * k_block, bytes);
    for (std::uint64_t block = first; block < last; ++block) {
      const std::span<const std::byte> rest = std::span(bytes).subspan((block - first) * k_block);
      const auto part = rest.first(std::min(rest.size(), k_block));
      web().memory.keep({source_->number(), block},
                        std::make_shared<const std::vector<std::byte>>(part.begin(), part.end()));
      if (folder_ != nullptr) folder_->keep(key_of(block), part);
    }
    return bytes;
  }

  std::shared_ptr<HttpSource> source_;
  std::string url_, name_;
  std::function<void(const WholeFetch&)> permit_;
  BlockFolder* folder_ = nullptr;
  std::uint64_t next_ = 0;   ///< where the last read ended
  std::uint64_t ahead_ = 0;  ///< bytes to fetch more than requested
};

std::unique_ptr<RemoteFile> open_file(const std::string& name, const RemoteOptions& options) {
  const std::string url = web_url(name);
  web(options);
  if (!url.empty())
    return std::make_unique<HttpFile>(http_source(name, url, options.hosts), url, name, options.permit);
  return std::make_unique<VirtualFile>(name, virtual_name(name), options.permit);
}

}  // namespace

std::unique_ptr<RemoteFile> open_remote_file(const std::string& name, const RemoteOptions& options) {
  [[maybe_unused]] static const bool is_set = (set_defaults(), true);
  const QuietGdal quiet;
  auto file = open_file(name, options);
  return is_packed(name) ? std::make_unique<UnpackedFile>(name, *file) : std::move(file);
}

RemoteTraffic remote_traffic() {
  RemoteTraffic traffic = http_traffic();
  const GdalHandle<VSIFree, char> text(VSINetworkStatsGetAsSerializedJSON(nullptr));
  if (!text) return traffic;
  const nlohmann::json document = nlohmann::json::parse(text.get(), nullptr, false);
  if (!document.contains("methods")) return traffic;
  for (const nlohmann::json& method : document["methods"]) {
    traffic.requests += method.value("count", std::uint64_t{0});
    traffic.bytes += method.value("downloaded_bytes", std::uint64_t{0});
  }
  return traffic;
}

}  // namespace alidade::geo
