// SPDX-License-Identifier: MIT
#include "extensions/web/http_source.h"

#include <fmt/format.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <future>
#include <string_view>
#include <thread>

#include "base/allowed_hosts.h"
#include "base/error.h"
#include "base/fingerprint.h"
#include "base/words.h"
#include "geo/gdal_reference.h"

namespace alidade::geo {

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

namespace {

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
  const GdalHandle<CSLDestroy, char*> list(has_lines ? CSLTokenizeString2(own, "\r\n", 0)
                                                     : CSLTokenizeString2(own, ",", CSLT_HONOURSTRINGS));
  for (char** one = list.get(); one != nullptr && *one != nullptr; ++one)
    headers += std::string("\r\n") + *one;
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
  GdalHandle<CPLHTTPDestroyResult, CPLHTTPResult> result{};

 private:
  void run(const std::string& url, const std::string& headers) {
    {
      const QuietGdal quiet;
      const Session session;
      const std::string stated = "HEADERS=" + headers;
      // A session would send no bodies after a request without one.
      const std::string mode = part_ == HttpPart::headers ? "NO_BODY=YES" : "PERSISTENT=" + session.name();
      const char* const options[] = {stated.c_str(), mode.c_str(), "MAX_RETRY=0", nullptr};
      result.reset(CPLHTTPFetchEx(url.c_str(), options, &Transfer::go_on, this, &Transfer::write, this));
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

/// Sends a request through GDAL's HTTP client, once, and waits for the answer, which is not compared with
/// the request. Thread safe; as many connections are kept as there are requests at once. Errors: this GDAL
/// has no HTTP client; more than k_largest_body bytes come; those of temporary_folder() and
/// ScratchFile::append(). Cancelled.
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

constexpr int k_no_such_range = 416;
constexpr const char* k_unstated = "the server does not state which bytes it sent";

/// The answers of servers without ranges, in one temporary file of the process. Thread safe.
class WholeFiles {
 public:
  /// Copies a file, so that none of thousands keeps a file handle; returns where. Errors: those of
  /// temporary_folder() and ScratchFile::append().
  WholeFile keep(const ScratchFile& whole) {
    constexpr std::uint64_t k_part = 1 << 20;
    const std::scoped_lock lock(mutex_);
    // A process that forked shares the file with its parent: each would overwrite what the other appends.
    if (!file_ || owner_ != ::getpid()) {
      file_ = std::make_shared<ScratchFile>(temporary_folder());
      owner_ = ::getpid();
    }
    const std::uint64_t at = file_->size();
    try {
      std::vector<std::byte> part;
      for (std::uint64_t begin = 0; begin < whole.size(); begin += part.size()) {
        part.resize(static_cast<std::size_t>(std::min(k_part, whole.size() - begin)));
        whole.read(begin, part);
        file_->append(part);
      }
    } catch (const Error&) {
      file_->cut(at);
      throw;
    }
    return {file_, at};
  }

 private:
  std::mutex mutex_;
  std::shared_ptr<ScratchFile> file_{};
  ::pid_t owner_ = 0;
};

WholeFiles& whole_files() {
  static WholeFiles& files = *new WholeFiles;  // never destroyed: other static objects may read files
  return files;
}

bool is_worth_repeating(const HttpAnswer& answer, bool is_open) {
  // Of libcurl: no such host, no connection.
  if (answer.curl_code != 0) return is_open || (answer.curl_code != 6 && answer.curl_code != 7);
  constexpr std::array k_busy = {429, 500, 502, 503, 504};
  return std::ranges::find(k_busy, answer.status) != k_busy.end();
}

}  // namespace

RemoteTraffic http_traffic() {
  return {requests_in_all, bytes_in_all};
}

void HttpSource::check_range(const HttpAnswer& answer, std::uint64_t first, std::uint64_t last) const {
  const auto fail = [&](const char* problem, std::string expected, std::string found) {
    throw Error({.file = name_,
                 .location = fmt::format("byte {}", first),
                 .problem = problem,
                 .expected = std::move(expected),
                 .found = std::move(found)});
  };
  if (answer.stated_range.empty()) {
    if (is_open_ && answer.size() == last - first + 1 && answer.size() != size_)
      fail(k_unstated, "the header Content-Range", "none");
    return;  // the whole file, as check_whole() or check_version() verifies
  }
  if (!answer.range || !answer.range->bytes)
    fail("invalid Content-Range from the server", "bytes FIRST-LAST/SIZE", answer.stated_range);
  const std::uint64_t last_there = std::min(last, answer.range->size - 1);
  if (*answer.range->bytes != std::pair(first, last_there))
    fail("the server sent other bytes than requested", fmt::format("bytes {}-{}", first, last_there),
         answer.stated_range);
  if (answer.size() != last_there - first + 1)
    fail("the server sent another number of bytes than it stated", fmt::format("{}", last_there - first + 1),
         fmt::format("{}", answer.size()));
}

void HttpSource::check_hosts(const HttpAnswer& answer) const {
  if (!hosts_) return;
  for (const std::string& stated : answer.redirections) {
    const std::string_view target = trim(stated);
    // Without a host in front it is another file of this host.
    const bool has_host =
        target.starts_with("//") || target.find(':') < std::min(target.find_first_of("/?#"), target.size());
    if (!has_host) continue;
    const std::string host = host_of(target.starts_with("//") ? "https:" + std::string(target) : target);
    if (!host.empty() && (host == host_of(url_) || std::ranges::find(*hosts_, host) != hosts_->end()))
      continue;
    throw Error({.file = name_,
                 .problem = "the server redirects to a host that is not allowed",
                 .expected = host.empty() ? "a redirection to http(s)" : "--allow-host " + host,
                 .found = quote(target)});
  }
}

void HttpSource::check_whole(const HttpAnswer& start) {
  const std::uint64_t end = std::max<std::uint64_t>(start.body.size(), 1);
  const HttpAnswer behind = request(end, end + start.body.size());
  const bool ends_there =
      behind.status == k_no_such_range && (!behind.range || behind.range->size == start.body.size());
  const bool is_sent_again = behind.is_good() && !behind.range && !behind.whole && behind.body == start.body;
  if (!ends_there && !is_sent_again)
    throw Error({.file = name_,
                 .location = "byte 0",
                 .problem = k_unstated,
                 .expected = "the header Content-Range",
                 .found = "none"});
}

HttpSource::HttpSource(std::string name, std::string url, std::size_t count, bool (*is_interrupted)(),
                       std::optional<std::vector<std::string>> hosts, std::optional<std::uint64_t> known)
    : name_(std::move(name)),
      url_(std::move(url)),
      is_interrupted_(is_interrupted),
      hosts_(std::move(hosts)) {
  is_open_ = known && open_by_headers(*known);
  if (is_open_) return;
  HttpAnswer answer = request(0, count - 1);
  if (!answer.range && !answer.whole) check_whole(answer);
  size_ = answer.range ? answer.range->size : answer.size();
  take_version(answer);
  start_ = std::move(answer.body);
  if (answer.whole) {
    start_.resize(count);
    answer.whole->read(0, start_);
    whole_ = whole_files().keep(*answer.whole);
  }
  is_open_ = true;
}

bool HttpSource::open_by_headers(std::uint64_t known) {
  const HttpAnswer answer = fetch(0, 0, HttpPart::headers);
  if (!answer.is_good() || !answer.length) return false;
  size_ = *answer.length;
  take_version(answer);
  return sum_of_version() == known;
}

std::uint64_t HttpSource::sum_of_version() const {
  return checksum(std::as_bytes(std::span(version_)));
}

void HttpSource::take_version(const HttpAnswer& answer) {
  etag_ = answer.etag;
  last_modified_ = answer.last_modified;
  const std::string& validator = etag_.empty() ? last_modified_ : etag_;
  version_ = validator.empty() ? "" : fmt::format("{} {}", size_, validator);
}

void HttpSource::read(std::uint64_t offset, std::span<std::byte> into) {
  {
    std::unique_lock lock(mutex_);
    if (whole_) {
      lock.unlock();
      return whole_->file->read(whole_->at + offset, into);
    }
  }
  const HttpAnswer answer = request(offset, offset + into.size() - 1);
  check_version(answer);
  if (!answer.whole) {
    std::ranges::copy(answer.body, into.begin());
    return;
  }
  answer.whole->read(offset, into);
  const std::scoped_lock lock(mutex_);
  if (!whole_) whole_ = whole_files().keep(*answer.whole);
}

void HttpSource::check_version(const HttpAnswer& answer) {
  const std::uint64_t size = answer.range ? answer.range->size : answer.size();
  const auto differs = [](const std::string& before, const std::string& now) {
    return !before.empty() && !now.empty() && before != now;
  };
  const bool has_other_tag = differs(etag_, answer.etag);
  const bool has_other_time = differs(last_modified_, answer.last_modified);
  if (size == size_ && !has_other_tag && !has_other_time) return;
  has_changed_ = true;
  const auto describe = [&](std::uint64_t bytes, const std::string& etag, const std::string& time) {
    return fmt::format("{} bytes", bytes) + (has_other_tag    ? ", ETag " + etag
                                             : has_other_time ? ", modified " + time
                                                              : "");
  };
  throw Error({.file = name_,
               .problem = "the file changed on the server while it was read; read it again",
               .expected = describe(size_, etag_, last_modified_),
               .found = describe(size, answer.etag, answer.last_modified)});
}

HttpAnswer HttpSource::request(std::uint64_t first, std::uint64_t last) {
  const int retries = std::atoi(CPLGetConfigOption("GDAL_HTTP_MAX_RETRY", "3"));
  double pause = CPLAtof(CPLGetConfigOption("GDAL_HTTP_RETRY_DELAY", "1"));
  for (int attempt = 0;; ++attempt, pause *= 2.0) {
    HttpAnswer answer = fetch(first, last, HttpPart::bytes);
    if (answer.is_good()) return answer;
    // Nothing at or behind `first`: an empty file, or one that has become shorter.
    if (answer.status == k_no_such_range && !is_open_ && first > 0) return answer;
    if (answer.status == k_no_such_range && answer.range) {
      if (is_open_) check_version(answer);
      answer.body.clear();
      answer.whole.reset();
      if (answer.range->size == 0 && first == 0) return answer;
    }
    if (attempt >= retries || !is_worth_repeating(answer, is_open_)) {
      const std::string tries = attempt > 0 ? fmt::format(" ({} attempts)", attempt + 1) : "";
      const bool is_slow = answer.problem.find("too slow") != std::string::npos;  // as libcurl puts it
      throw Error(
          {.file = name_,
           .problem = fmt::format("cannot read from the server{}: {}", tries, answer.problem),
           .expected = is_slow ? "a faster one, or a lower GDAL_HTTP_LOW_SPEED_LIMIT (bytes/s)" : ""});
    }
    wait(pause);
  }
}

void HttpSource::wait(double seconds) const {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
    if (is_stopped()) throw Cancelled();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

HttpAnswer HttpSource::fetch(std::uint64_t first, std::uint64_t last, HttpPart part) const {
  HttpAnswer answer = send({.name = name_,
                            .url = url_,
                            .first = first,
                            .last = last,
                            .part = part,
                            .is_interrupted = is_interrupted_});
  check_hosts(answer);
  if (answer.is_good() && part == HttpPart::bytes) check_range(answer, first, last);
  return answer;
}

}  // namespace alidade::geo
