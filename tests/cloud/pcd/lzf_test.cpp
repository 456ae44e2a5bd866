// SPDX-License-Identifier: MIT
#include "cloud/pcd/pcd_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>

namespace alidade::test {
namespace {

/// LZF of literals only.
std::string literals(std::string_view bytes) {
  std::string packed;
  for (; !bytes.empty(); bytes.remove_prefix(std::min<std::size_t>(32, bytes.size()))) {
    const std::string_view run = bytes.substr(0, 32);
    packed += static_cast<char>(run.size() - 1);
    packed += run;
  }
  return packed;
}

std::optional<std::string> unpack(std::string_view packed, std::size_t size) {
  std::string unpacked(size, '?');
  if (!decode_lzf(std::as_bytes(std::span(packed)), std::as_writable_bytes(std::span(unpacked))))
    return std::nullopt;
  return unpacked;
}

TEST(Lzf, literals_and_references_near_and_far_and_overlapping) {
  using namespace std::string_literals;
  EXPECT_EQ(unpack(""s, 0), "");
  EXPECT_EQ(unpack("\x02"
                   "abc"s,
                   3),
            "abc");
  EXPECT_EQ(unpack("\x02"
                   "abc\x20\x02"s,
                   6),
            "abcabc");                            // length 3, distance 3
  EXPECT_EQ(unpack("\0a\x80\0"s, 7), "aaaaaaa");  // length 6, distance 1
  EXPECT_EQ(unpack("\x01"
                   "ab\xe0\x03\x01"s,
                   14),
            "ababababababab");  // length 7 + 3 + 2, distance 2
  std::string far = literals(std::string(300, 'x') + "yz");
  EXPECT_EQ(unpack(far + "\x21\x2c"s, 305), std::string(300, 'x') + "yz" + "xxx");  // distance 301
}

TEST(Lzf, damaged_streams_are_rejected) {
  using namespace std::string_literals;
  EXPECT_FALSE(
      unpack("\x02"
             "ab"s,
             3));  // literals end early
  EXPECT_FALSE(
      unpack("\x02"
             "abc"s,
             2));  // more than announced
  EXPECT_FALSE(
      unpack("\x02"
             "abc"s,
             4));  // less than announced
  EXPECT_FALSE(
      unpack("\x02"
             "abc\x20\x03"s,
             6));  // reference before the start
  EXPECT_FALSE(
      unpack("\x02"
             "abc\x20"s,
             6));  // reference cut off
  EXPECT_FALSE(
      unpack("\x02"
             "abc\xe0\x05"s,
             17));  // long reference cut off
  EXPECT_FALSE(
      unpack("\x02"
             "abc\x40\x02"s,
             6));  // reference beyond the end
}

}  // namespace
}  // namespace alidade::test
