// SPDX-License-Identifier: MIT
// Index files on the web and in archives are fetched whole, large ones only by those who agree.
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "base/fingerprint.h"
#include "base/input_file.h"
#include "octree/build.h"
#include "octree/index_file/index_header.h"
#include "octree/index_file/save_index.h"
#include "tests/tools/run_program.h"
#include "tests/tools/terminal.h"

namespace alidade::test {
namespace {

/// An archive of the index file of a small cloud that has 1.2 GB of other data in front of the metadata. They
/// are a hole in the archive, and no query gets to the end of reading them.
void write_huge(const std::filesystem::path& archive, const std::filesystem::path& small) {
  PointCloud cloud;
  cloud.lattice = {glm::dvec3(1), glm::dvec3(0)};
  cloud.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  save_index(small, build(cloud), cloud);
  std::vector<std::byte> bytes(std::filesystem::file_size(small));
  InputFile(small).read_at(0, bytes);
  const IndexHeader known = read_index_header(std::span(bytes).first(k_index_page), bytes.size(), "small");
  IndexHeader huge = known;
  const auto metadata = std::ranges::find(huge.sections, IndexSection::metadata, &SectionEntry::kind);
  huge.sections.insert(metadata, {.kind = IndexSection::extra_dimensions, .bytes = 1'200'000'000});
  std::uint64_t end = k_index_page, sums = 0;
  for (SectionEntry& section : huge.sections) {
    if (section.kind == IndexSection::checksums) section.bytes = sums * sizeof(std::uint64_t);
    section.offset = align_to_page(end);
    end = section.end();
    sums += checksum_blocks(section.bytes);
  }
  huge.file_bytes = end;

  std::ofstream tar(archive, std::ios::binary);
  constexpr std::uint64_t k_record = 512;
  const auto put = [&](std::uint64_t offset, std::span<const std::byte> part) {
    tar.seekp(static_cast<std::streamoff>(k_record + offset));
    tar.write(reinterpret_cast<const char*>(part.data()), static_cast<std::streamsize>(part.size()));
  };
  put(0, encode_index_header(huge));
  std::uint64_t sum = 0, known_sum = 0;
  for (const SectionEntry& section : huge.sections) {
    const SectionEntry* const before = known.find(section.kind);
    const auto count = checksum_blocks(section.bytes);
    if (before != nullptr && section.kind != IndexSection::checksums) {
      put(section.offset, std::span(bytes).subspan(before->offset, before->bytes));
      put(huge.find(IndexSection::checksums)->offset + sum * sizeof(std::uint64_t),
          std::span(bytes).subspan(
              known.find(IndexSection::checksums)->offset + known_sum * sizeof(std::uint64_t),
              count * sizeof(std::uint64_t)));
      known_sum += count;
    }
    sum += count;
  }
  const std::uint64_t size = (end + k_record - 1) / k_record * k_record + 2 * k_record;
  put(size - 1, std::array{std::byte{0}});
  std::string head(k_record, '\0');
  const auto set = [&](std::size_t at, const std::string& text) { head.replace(at, text.size(), text); };
  set(0, "huge.alidade");
  set(100, "0000644");
  set(108, "0000000");
  set(116, "0000000");
  set(124, fmt::format("{:011o}", end));
  set(136, "00000000000");
  set(148, "        ");
  set(156, "0");
  set(257, "ustar");
  set(263, "00");
  unsigned head_sum = 0;
  for (const char byte : head) head_sum += static_cast<unsigned char>(byte);
  set(148, fmt::format("{:06o}", head_sum) + '\0');
  tar.seekp(0);
  tar.write(head.data(), static_cast<std::streamsize>(head.size()));
}

class FetchTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_huge(folder / "huge.tar", folder / "small.alidade");
  }
  const Words query_ = {"query", "/vsitar/huge.tar/huge.alidade", "--point", "0,0,0", "--k", "1"};
};

TEST_F(FetchTest, a_large_file_without_a_terminal_is_an_error_that_names_the_remedy) {
  const ProgramResult result = run(with(query_, {"-q"}));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(
      result.err,
      "alidade: error: /vsitar/huge.tar/huge.alidade: index files on the web are fetched whole, more than "
      "1 GB only if you agree; expected --yes, or a COPC file, of which only what is needed is fetched, "
      "found 1.2 GB\n");
  EXPECT_EQ(run({"info", "/vsitar/huge.tar/huge.alidade"}).exit_code, 0);
  EXPECT_EQ(run(with(query_, {"--dry-run"})).exit_code, 0);
}

TEST_F(FetchTest, a_terminal_is_asked) {
  constexpr const char* k_question = "huge.alidade: fetch 1.2 GB? [y/N] ";
  for (const char* const refusal : {"\n", "n\n", "yesterday\n"}) {
    Terminal terminal(folder, query_);
    EXPECT_TRUE(terminal.shows("", k_question));
    EXPECT_TRUE(terminal.shows(refusal, "only if you agree"));
    EXPECT_EQ(terminal.exit_code(), 2);
  }
  {
    Terminal terminal(folder, query_);
    EXPECT_TRUE(terminal.shows("", k_question));
    EXPECT_TRUE(terminal.shows("y\n", " %, "));
  }
  Terminal terminal(folder, query_);
  EXPECT_TRUE(terminal.shows("", k_question));
  EXPECT_TRUE(terminal.shows("\x03", "interrupted"));
  EXPECT_EQ(terminal.exit_code(), 130);
}

TEST_F(FetchTest, who_has_agreed_is_not_asked) {
  Terminal terminal(folder, with(query_, {"--yes"}));
  EXPECT_TRUE(terminal.shows("", "(not kept: only web servers that state its version allow that)"));
  EXPECT_TRUE(terminal.shows("", " %, "));
}

}  // namespace
}  // namespace alidade::test
