// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/scratch_file.h"

namespace alidade::geo {

enum class HttpPart { bytes, headers };

/// A request for bytes of a file on a web server, or for the headers alone.
struct HttpRequest {
  /// Most bytes from a server that sends no ranges.
  static constexpr std::uint64_t k_largest_body = std::uint64_t{1} << 30;

  std::string name;  ///< of the file, in messages
  std::string url;
  std::uint64_t first = 0, last = 0;
  HttpPart part = HttpPart::bytes;
  bool (*is_interrupted)() = nullptr;  ///< called while waiting; returns whether to stop
};

/// The header Content-Range: the first and the last byte, if there are any, and the file's size.
struct ContentRange {
  std::optional<std::pair<std::uint64_t, std::uint64_t>> bytes{};
  std::uint64_t size = 0;
};

struct HttpAnswer {
  int curl_code = 0;  ///< of libcurl; 0: the answer is complete
  int status = 0;     ///< from 400 on, otherwise 0
  std::string problem;
  std::string stated_range, etag, last_modified;
  std::vector<std::string> redirections;  ///< the headers Location, in their order
  std::optional<ContentRange> range;      ///< without one it is the whole file
  std::optional<std::uint64_t> length;    ///< the header Content-Length
  std::vector<std::byte> body;
  std::shared_ptr<ScratchFile> whole;  ///< instead of the body, if it is longer than requested

  std::uint64_t size() const { return whole ? whole->size() : body.size(); }
  bool is_good() const { return curl_code == 0 && status == 0; }
};

/// Sends a request through GDAL's HTTP client, once, and waits for the answer, which is not compared with
/// the request. Thread safe; as many connections are kept as there are requests at once. Errors: this GDAL
/// has no HTTP client; more than k_largest_body bytes come; those of temporary_folder() and
/// ScratchFile::append(). Cancelled.
HttpAnswer send(const HttpRequest& request);

struct HttpTraffic {
  std::uint64_t requests = 0;  ///< also those that were repeated
  std::uint64_t bytes = 0;     ///< of the bodies
};
/// Of all requests of the process.
HttpTraffic http_traffic();

}  // namespace alidade::geo
