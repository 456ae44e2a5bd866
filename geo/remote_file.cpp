// SPDX-License-Identifier: MIT
#include "geo/remote_file.h"

#include <cpl_conv.h>
#include <cpl_json.h>
#include <cpl_vsi.h>
#include <cpl_vsi_error.h>
#include <array>
#include <atomic>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.h"
#include "geo/gdal_reference.h"

namespace alidade::geo {
namespace {

/// The name of a virtual file of GDAL.
std::string virtual_name(const std::string& name) {
  constexpr std::array<std::pair<const char*, const char*>, 3> k_buckets = {
      {{"s3://", "/vsis3/"}, {"gs://", "/vsigs/"}, {"az://", "/vsiaz/"}}};
  for (const auto& [begin, folder] : k_buckets)
    if (name.starts_with(begin)) return folder + name.substr(std::string(begin).size());
  return name.starts_with("/vsi") ? name : "/vsicurl/" + name;
}

/// Whether it is a catalog that is compressed, to be read as if it were not.
bool is_packed(const std::string& name) {
  return name.substr(0, name.find('?')).ends_with(".json.gz") && !name.starts_with("/vsigzip/");
}

[[noreturn]] void fail(const std::string& name, const char* problem) {
  std::string reason = VSIGetLastErrorMsg();
  if (reason.empty()) reason = CPLGetLastErrorMsg();
  throw Error({.file = name, .problem = problem + (reason.empty() ? "" : ": " + reason)});
}

/// What is not set in the environment.
void set_defaults() {
  constexpr std::array<std::pair<const char*, const char*>, 8> k_defaults = {{
      {"GDAL_HTTP_MAX_RETRY", "3"},
      {"GDAL_HTTP_RETRY_DELAY", "1"},
      {"GDAL_HTTP_CONNECTTIMEOUT", "30"},
      {"GDAL_HTTP_LOW_SPEED_TIME", "30"},
      {"GDAL_HTTP_LOW_SPEED_LIMIT", "1"},
      {"CPL_VSIL_CURL_CACHE_SIZE", "67108864"},
      {"CPL_VSIL_NETWORK_STATS_ENABLED", "YES"},
      {"CPL_VSIL_GZIP_WRITE_PROPERTIES", "NO"},
  }};
  for (const auto& [option, value] : k_defaults)
    if (CPLGetConfigOption(option, nullptr) == nullptr) CPLSetConfigOption(option, value);
}

class VirtualFile final : public RemoteFile {
 public:
  explicit VirtualFile(const std::string& name) : name_(name) {
    const QuietGdal quiet;
    VSIErrorReset();
    // The other files of its folder do not matter.
    constexpr const char* k_list = "GDAL_DISABLE_READDIR_ON_OPEN";
    CPLSetThreadLocalConfigOption(k_list, "EMPTY_DIR");
    handle_.reset(VSIFOpenExL(virtual_name(name).c_str(), "rb", TRUE));
    CPLSetThreadLocalConfigOption(k_list, nullptr);
    if (!handle_) fail(name, "cannot open the file");
    measure();
    if (is_packed(name)) unpack();
  }

  std::uint64_t size() const override { return size_; }

  void read(std::uint64_t offset, std::span<std::byte> into) override {
    const QuietGdal quiet;
    VSIErrorReset();
    if (VSIFSeekL(handle_.get(), offset, SEEK_SET) != 0 ||
        VSIFReadL(into.data(), 1, into.size(), handle_.get()) != into.size())
      fail(name_, "cannot read the file");
  }

 private:
  struct Close {
    void operator()(VSILFILE* file) const { VSIFCloseL(file); }
  };

  void measure() {
    if (VSIFSeekL(handle_.get(), 0, SEEK_END) != 0) fail(name_, "cannot measure the file");
    size_ = VSIFTellL(handle_.get());
  }

  /// Goes on with what is packed in the file, which is fetched at once: unpacking as it comes would take more requests.
  void unpack() {
    constexpr std::uint64_t k_largest = std::uint64_t{256} << 20;
    if (size_ > k_largest)
      throw Error({.file = name_,
                   .problem = "the compressed catalog is too large",
                   .expected = std::to_string(k_largest) + " bytes",
                   .found = std::to_string(size_)});
    static std::atomic<int> count = 0;
    // A number: GDAL remembers what files of a name had in them.
    packed_.emplace(("_" + std::to_string(count++) + ".gz").c_str());
    std::vector<std::byte> bytes(static_cast<std::size_t>(size_));
    read(0, bytes);
    handle_.reset(VSIFOpenL(packed_->name(), "wb"));
    if (!handle_ || VSIFWriteL(bytes.data(), 1, bytes.size(), handle_.get()) != bytes.size())
      fail(name_, "cannot keep the file in memory");
    handle_.reset(VSIFOpenL((std::string("/vsigzip/") + packed_->name()).c_str(), "rb"));
    if (!handle_) fail(name_, "cannot decompress the file");
    measure();
  }

  std::string name_;
  std::optional<GdalMemoryFile> packed_{};
  std::unique_ptr<VSILFILE, Close> handle_;
  std::uint64_t size_ = 0;
};

}  // namespace

std::unique_ptr<RemoteFile> open_remote_file(const std::string& name) {
  [[maybe_unused]] static const bool is_set = (set_defaults(), true);
  return std::make_unique<VirtualFile>(name);
}

RemoteTraffic remote_traffic() {
  const std::unique_ptr<char, decltype(&VSIFree)> text(VSINetworkStatsGetAsSerializedJSON(nullptr), &VSIFree);
  CPLJSONDocument document;
  RemoteTraffic traffic;
  if (!text || !document.LoadMemory(text.get())) return traffic;
  for (const CPLJSONObject& method : document.GetRoot().GetObj("methods").GetChildren()) {
    traffic.requests += static_cast<std::uint64_t>(method.GetLong("count"));
    traffic.bytes += static_cast<std::uint64_t>(method.GetLong("downloaded_bytes"));
  }
  return traffic;
}

}  // namespace alidade::geo
