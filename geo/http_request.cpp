// SPDX-License-Identifier: MIT
#include "geo/http_request.h"

#include <cpl_conv.h>
#include <cpl_http.h>
#include <cpl_string.h>
#include <fmt/format.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <future>
#include <mutex>
#include <string_view>
#include <thread>
#include <utility>

#include "base/error.h"
#include "geo/gdal_reference.h"

namespace alidade::geo {
namespace {

std::atomic<std::uint64_t> requests_in_all = 0, bytes_in_all = 0;
constexpr std::uint64_t k_largest_page = 64 << 10;  // of an error

std::optional<std::uint64_t> take_number(std::string_view& text) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

bool take(std::string_view& text, std::string_view begin) {
  if (!text.starts_with(begin)) return false;
  text.remove_prefix(begin.size());
  return true;
}

std::optional<std::uint64_t> parse_number(std::string_view text) {
  const auto number = take_number(text);
  return text.empty() ? number : std::nullopt;
}

/// "bytes 0-99/1000" or "bytes */1000".
std::optional<ContentRange> parse_content_range(std::string_view text) {
  ContentRange range;
  if (!take(text, "bytes ")) return std::nullopt;
  if (!take(text, "*")) {
    const auto first = take_number(text);
    if (!first || !take(text, "-")) return std::nullopt;
    const auto last = take_number(text);
    if (!last || *last < *first) return std::nullopt;
    range.bytes = {*first, *last};
  }
  if (!take(text, "/")) return std::nullopt;
  const auto size = take_number(text);
  if (!size || !text.empty() || (range.bytes && range.bytes->second >= *size)) return std::nullopt;
  range.size = *size;
  return range;
}

/// The headers of a request: the range, what keeps the bytes as they are, and those of the user.
std::string headers_of(const HttpRequest& request) {
  std::string headers = "Accept-Encoding: identity";
  if (request.part == HttpPart::bytes)
    headers += fmt::format("\r\nRange: bytes={}-{}", request.first, request.last);
  // GDAL takes them from its configuration only if a request has none.
  const char* const own = CPLGetConfigOption("GDAL_HTTP_HEADERS", nullptr);
  if (own == nullptr) return headers;
  const bool has_lines = std::strstr(own, "\r\n") != nullptr;
  const CPLStringList list(has_lines ? CSLTokenizeString2(own, "\r\n", 0)
                                     : CSLTokenizeString2(own, ",", CSLT_HONOURSTRINGS));
  for (int i = 0; i < list.size(); ++i) headers += std::string("\r\n") + list[i];
  return headers;
}

/// Where the headers certainly belong to the last answer. GDAL gives those of redirections and of the last
/// answer in one list: where a name comes again, another answer has begun.
int begin_of_last_answer(char** headers) {
  constexpr std::array k_repeated = {"Set-Cookie", "Link", "Vary", "Via", "Warning", "WWW-Authenticate"};
  int redirections = 0, answers = 0, begin = 0, count = 0;
  std::vector<std::string> seen;
  for (; headers != nullptr && headers[count] != nullptr; ++count) {
    std::string name = headers[count];
    name.resize(name.find_first_of(":=") == std::string::npos ? name.size() : name.find_first_of(":="));
    const auto is_name = [&](const auto& other) { return EQUAL(name.c_str(), std::string(other).c_str()); };
    if (is_name("Location")) ++redirections;
    if (std::ranges::any_of(k_repeated, is_name)) continue;
    if (std::ranges::any_of(seen, is_name)) {
      ++answers;
      begin = count;
      seen.clear();
    }
    seen.push_back(std::move(name));
  }
  if (redirections == 0) return 0;
  return answers >= redirections ? begin : count;
}

/// A session of GDAL, which keeps connections to servers, for one request at a time: as many as there are
/// requests at once. A process that forked gets others: on one connection its answers and its parent's would
/// mix.
class Session {
 public:
  Session() {
    const std::scoped_lock lock(mutex_);
    if (free_.empty()) free_.push_back(count_++);
    number_ = free_.back();
    free_.pop_back();
  }
  ~Session() {
    const std::scoped_lock lock(mutex_);
    free_.push_back(number_);
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  std::string name() const { return fmt::format("alidade_{}_{}", ::getpid(), number_); }

 private:
  static inline std::mutex mutex_;
  static inline std::vector<int> free_;
  static inline int count_ = 0;
  int number_;
};

/// A request and its answer, in a thread of its own: GDAL calls its progress function only once the
/// answer has begun.
class Transfer {
 public:
  static std::shared_ptr<Transfer> start(const HttpRequest& request) {
    auto transfer = std::make_shared<Transfer>();
    transfer->part_ = request.part;
    transfer->most_bytes_ = std::max(request.last - request.first + 1, k_largest_page);
    ++requests_in_all;
    std::thread([transfer, url = request.url, headers = headers_of(request)] {
      transfer->run(url, headers);
    }).detach();
    return transfer;
  }

  bool is_done_within(std::chrono::milliseconds time) const {
    return done_future_.wait_for(time) == std::future_status::ready;
  }
  /// The thread ends as soon as data come.
  void give_up() { is_given_up_ = true; }

  // Valid once it is done.
  std::vector<std::byte> body{};
  std::shared_ptr<ScratchFile> whole{};  ///< has all of the body
  bool is_too_long = false;
  std::exception_ptr problem{};
  std::unique_ptr<CPLHTTPResult, decltype(&CPLHTTPDestroyResult)> result{nullptr, &CPLHTTPDestroyResult};

 private:
  void run(const std::string& url, const std::string& headers) {
    {
      const QuietGdal quiet;
      const Session session;
      CPLStringList options;
      options.SetNameValue("HEADERS", headers.c_str());
      // A session would send no bodies from then on.
      if (part_ == HttpPart::headers)
        options.SetNameValue("NO_BODY", "YES");
      else
        options.SetNameValue("PERSISTENT", session.name().c_str());
      options.SetNameValue("MAX_RETRY", "0");
      result.reset(
          CPLHTTPFetchEx(url.c_str(), options.List(), &Transfer::go_on, this, &Transfer::write, this));
    }
    done_.set_value();
  }

  static std::size_t write(void* bytes, std::size_t size, std::size_t count, void* transfer) {
    auto& self = *static_cast<Transfer*>(transfer);
    const std::span<const std::byte> part(static_cast<const std::byte*>(bytes), size * count);
    bytes_in_all += part.size();
    try {
      self.add(part);
    } catch (...) {
      self.problem = std::current_exception();
    }
    return self.is_too_long || self.problem ? 0 : part.size();
  }
  void add(std::span<const std::byte> part) {
    const std::uint64_t bytes = (whole ? whole->size() : body.size()) + part.size();
    is_too_long = bytes > HttpRequest::k_largest_body;
    if (is_too_long) return;
    if (!whole && bytes > most_bytes_) {
      whole = std::make_shared<ScratchFile>(temporary_folder());
      whole->append(std::exchange(body, {}));
    }
    if (whole)
      whole->append(part);
    else
      body.insert(body.end(), part.begin(), part.end());
  }
  static int go_on(double, const char*, void* transfer) {
    return static_cast<Transfer*>(transfer)->is_given_up_ ? FALSE : TRUE;
  }

  /// Of a body in memory; a longer one goes to a temporary file. At least k_largest_page, since a body may be
  /// the page of an error.
  std::uint64_t most_bytes_ = 0;
  HttpPart part_ = HttpPart::bytes;
  std::atomic<bool> is_given_up_ = false;
  std::promise<void> done_;
  std::future<void> done_future_ = done_.get_future();
};

}  // namespace

HttpTraffic http_traffic() {
  return {requests_in_all, bytes_in_all};
}

HttpAnswer send(const HttpRequest& request) {
  const auto is_stopped = [&] { return request.is_interrupted != nullptr && request.is_interrupted(); };
  const std::shared_ptr<Transfer> transfer = Transfer::start(request);
  while (!transfer->is_done_within(std::chrono::milliseconds(50))) {
    if (!is_stopped()) continue;
    transfer->give_up();
    throw Cancelled();
  }
  if (is_stopped()) throw Cancelled();
  if (transfer->problem) std::rethrow_exception(transfer->problem);
  const auto& result = transfer->result;
  if (!result) throw Error({.file = request.name, .problem = "this GDAL reads no files from web servers"});
  if (transfer->is_too_long)
    throw Error(
        {.file = request.name,
         .problem = "the server sends no ranges, and the file is too large to fetch whole; download it",
         .expected = fmt::format("at most {} bytes", HttpRequest::k_largest_body)});

  const auto values = [&](const char* key, int begin) {
    std::vector<std::string> found;
    for (char** line = result->papszHeaders == nullptr ? nullptr : result->papszHeaders + begin;
         line != nullptr && *line != nullptr; ++line) {
      char* name = nullptr;
      const char* const text = CPLParseNameValue(*line, &name);
      if (text != nullptr && name != nullptr && EQUAL(name, key)) found.emplace_back(text);
      CPLFree(name);
    }
    return found;
  };
  // The last of a name: those of redirections come before.
  const auto header = [&](const char* key, int begin) {
    const std::vector<std::string> all = values(key, begin);
    return all.empty() ? std::string() : all.back();
  };
  const int begin = begin_of_last_answer(result->papszHeaders);
  HttpAnswer answer;
  answer.redirections = values("Location", 0);
  answer.curl_code = result->nStatus;
  answer.stated_range = header("Content-Range", 0);
  answer.length = parse_number(header("Content-Length", begin));
  answer.etag = header("ETag", begin);
  answer.last_modified = header("Last-Modified", begin);
  answer.problem = result->pszErrBuf != nullptr ? result->pszErrBuf : "unknown reason";
  if (answer.etag.starts_with("W/")) answer.etag.erase(0, 2);
  constexpr std::string_view k_status = "HTTP error code : ";
  if (answer.curl_code == 0 && answer.problem.starts_with(k_status)) {
    answer.status = std::atoi(answer.problem.c_str() + k_status.size());
    answer.problem = fmt::format("HTTP status {}", answer.status);
  }
  answer.range = parse_content_range(answer.stated_range);
  answer.body = std::move(transfer->body);
  answer.whole = std::move(transfer->whole);
  if (answer.is_good() && answer.body.size() > request.last - request.first + 1) {
    answer.whole = std::make_shared<ScratchFile>(temporary_folder());
    answer.whole->append(std::exchange(answer.body, {}));
  }
  return answer;
}

}  // namespace alidade::geo
