// SPDX-License-Identifier: MIT
#include "tools/query/line_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <utility>

#include "base/error.h"
#include "base/words.h"
#include "tools/console.h"

namespace alidade::tools {
namespace {

constexpr std::size_t k_block_bytes = 1 << 20;

}  // namespace

std::string_view LineBlock::line(std::size_t i) const {
  const std::size_t begin = i == 0 ? 0 : ends[i - 1] + 1;
  std::string_view line = std::string_view(text).substr(begin, ends[i] - begin);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

LineSource LineSource::open(const std::string& name) {
  if (name == "-") return {"standard input", FileDescriptor(::dup(STDIN_FILENO))};
  FileDescriptor descriptor(::open(name.c_str(), O_RDONLY | O_CLOEXEC));
  if (!descriptor.is_open()) throw system_error(name, "cannot open the file");
  LineSource source(name, std::move(descriptor));
  struct stat status {};
  if (::fstat(source.descriptor_.number(), &status) == 0 && S_ISREG(status.st_mode))
    source.total_ = static_cast<std::uint64_t>(status.st_size);
  return source;
}

LineSource LineSource::command_line(std::string option, const std::vector<std::string>& values) {
  LineSource source(std::move(option), {});
  for (const std::string& value : values) source.waiting_ += value + "\n";
  return source;
}

/// Fills up `waiting_`; false at the end.
bool LineSource::read_more() {
  if (!descriptor_.is_open()) return false;
  const std::size_t before = waiting_.size();
  std::size_t have = before;
  waiting_.resize(before + k_block_bytes);
  while (have < waiting_.size()) {
    if (interrupted()) throw Cancelled();
    const ::ssize_t count = ::read(descriptor_.number(), waiting_.data() + have, waiting_.size() - have);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw system_error(name_, "cannot read the file");
    if (count == 0) break;
    have += static_cast<std::size_t>(count);
  }
  waiting_.resize(have);
  return have > before;
}

bool LineSource::next(LineBlock& block) {
  block.text.clear();
  block.ends.clear();
  block.first_number = next_number_;
  const bool more = read_more();
  if (next_number_ == 1 && done_ == 0 && waiting_.starts_with(k_byte_order_mark))
    waiting_.erase(0, k_byte_order_mark.size());
  if (waiting_.empty()) return false;
  // At the end of the text the last line may lack its end.
  const std::size_t last_end = waiting_.rfind('\n');
  if (more && last_end == std::string::npos && waiting_.size() >= k_block_bytes) {
    throw Error({.file = name_,
                 .location = std::to_string(next_number_) + ":1",
                 .problem = "line too long",
                 .expected = "at most " + std::to_string(k_block_bytes) + " bytes"});
  }
  const std::size_t size = last_end == std::string::npos ? waiting_.size() : last_end + 1;
  std::string rest = waiting_.substr(size);
  waiting_.resize(size);
  block.text = std::move(waiting_);
  waiting_ = std::move(rest);
  for (std::size_t end = block.text.find('\n'); end != std::string::npos;
       end = block.text.find('\n', end + 1))
    block.ends.push_back(end);
  if (!block.text.ends_with('\n')) block.ends.push_back(block.text.size());
  next_number_ += block.size();
  done_ += size;
  return true;
}

}  // namespace alidade::tools
