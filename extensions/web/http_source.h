// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/scratch_file.h"
#include "extensions/web/remote_file.h"

namespace alidade::geo {

enum class HttpPart { bytes, headers };
struct HttpAnswer;

/// Of all HTTP requests of the process; bytes are those of the bodies.
RemoteTraffic http_traffic();

/// Where the answer of a server without ranges is in a temporary file.
struct WholeFile {
  std::shared_ptr<const ScratchFile> file;
  std::uint64_t at = 0;
};

/// A file on a web server, read by ranges through GDAL's HTTP client. Thread safe.
///
/// The first answer fixes which file it is: its size, and its entity tag or else its time of modification.
/// Every later answer must agree, and must hold exactly the bytes that were requested; otherwise it is an
/// Error, so that no reader gets bytes of two versions. A server that does not support ranges sends the whole
/// file, which an unnamed file in temporary_folder() holds until the process ends.
///
/// Requests that fail in the network, and those answered with 429, 500, 502, 503 or 504, are repeated
/// GDAL_HTTP_MAX_RETRY times, with pauses that begin at GDAL_HTTP_RETRY_DELAY seconds and double.
class HttpSource {
 public:
  /// Requests the first `count` bytes. With `known`, the sum_of_version() of a file without ranges that is
  /// kept elsewhere, the headers come first, and no bytes if they state this version: some servers state a
  /// wrong length or ETag there. `name` is the file's in messages; `is_interrupted`, if given, is called
  /// while waiting and returns whether to stop. With `hosts`, an answer that came from another host than
  /// that of the URL and these is an error: GDAL follows redirections before reporting them, but their
  /// answers are discarded.
  /// Errors: those of read(); the server cannot be reached, or has no such file.
  HttpSource(std::string name, std::string url, std::size_t count, bool (*is_interrupted)(),
             std::optional<std::vector<std::string>> hosts, std::optional<std::uint64_t> known = {});

  /// No other source of the process has or had it.
  std::uint64_t number() const { return number_; }
  std::uint64_t size() const { return size_; }
  /// Differs between different contents of the URL. Empty if the server does not distinguish them.
  const std::string& version() const { return version_; }
  std::uint64_t sum_of_version() const;
  /// Whether the constructor got all of the file, since the server sends no ranges.
  bool has_whole() const { return whole_.has_value(); }
  /// Moves out the bytes that the constructor fetched: at most `count` at the beginning of the file, or none.
  std::vector<std::byte> take_start() { return std::exchange(start_, {}); }
  /// Whether an answer was of another version: the URL has to be opened again.
  bool has_changed() const { return has_changed_; }

  /// Fetches bytes, all of them within the file. Errors: the network fails; the server sends other bytes or
  /// another version. Cancelled.
  void read(std::uint64_t offset, std::span<std::byte> into);

 private:
  HttpAnswer request(std::uint64_t first, std::uint64_t last);
  HttpAnswer fetch(std::uint64_t first, std::uint64_t last, HttpPart part) const;
  /// Whether the headers state this version.
  bool open_by_headers(std::uint64_t known);
  void take_version(const HttpAnswer& answer);
  /// Errors: the answer does not hold just these bytes.
  void check_range(const HttpAnswer& answer, std::uint64_t first, std::uint64_t last) const;
  /// Errors: the answer is one of a host that is not allowed.
  void check_hosts(const HttpAnswer& answer) const;
  /// Makes sure that an answer to the first request that states no range is the whole file, by a request for
  /// what is behind it. Errors: it may be a part.
  void check_whole(const HttpAnswer& start);
  /// Errors: the answer is not of this version of the file.
  void check_version(const HttpAnswer& answer);
  void wait(double seconds) const;
  bool is_stopped() const { return is_interrupted_ != nullptr && is_interrupted_(); }

  static inline std::atomic<std::uint64_t> count_ = 0;
  const std::uint64_t number_ = count_++;
  std::string name_, url_;
  bool (*is_interrupted_)();
  std::optional<std::vector<std::string>> hosts_;
  std::uint64_t size_ = 0;
  std::string etag_, last_modified_, version_;
  std::vector<std::byte> start_;
  bool is_open_ = false;
  std::atomic<bool> has_changed_ = false;
  std::mutex mutex_;
  std::optional<WholeFile> whole_{};
};

}  // namespace alidade::geo
