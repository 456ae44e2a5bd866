// SPDX-License-Identifier: MIT
#include "geo/http_source.h"

#include <cpl_conv.h>
#include <fmt/format.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <thread>
#include <utility>

#include "base/allowed_hosts.h"
#include "base/error.h"
#include "base/fingerprint.h"
#include "base/scratch_file.h"
#include "base/words.h"

namespace alidade::geo {
namespace {

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
