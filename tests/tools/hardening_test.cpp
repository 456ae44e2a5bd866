// SPDX-License-Identifier: MIT
// What makes mistakes in reading untrusted files harder to use, in the program and its module.
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class HardeningTest : public ProgramTest {};

TEST_F(HardeningTest, program_and_module_are_position_independent_bound_at_start_and_guarded) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers do more than these flags, which they do not go with";
#endif
  const std::filesystem::path build = ALIDADE_BUILD_FOLDER;
  for (const char* const name : {"alidade", "alidade_openimageio.so"}) {
    const std::string file = (build / name).string();
    const std::string header = shell_output("readelf -hldW '" + file + "'", folder);
    if (header.empty()) GTEST_SKIP() << "readelf of Debian's binutils is not there";
    EXPECT_TRUE(contains(header, "DYN (")) << name;
    EXPECT_TRUE(contains(header, "GNU_RELRO")) << name;
    EXPECT_TRUE(contains(header, "BIND_NOW") || contains(header, "Flags: NOW")) << name;
    // The stack is not executable.
    EXPECT_FALSE(contains(shell_output("readelf -lW '" + file + "' | grep GNU_STACK", folder), "RWE"))
        << name;
    const std::string symbols = shell_output("readelf --dyn-syms -W '" + file + "'", folder);
    EXPECT_TRUE(contains(symbols, "__stack_chk_fail")) << name;
  }
}

TEST_F(HardeningTest, copies_into_buffers_of_known_size_are_checked_in_everything_that_is_installed) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(NDEBUG)
  GTEST_SKIP() << "_FORTIFY_SOURCE is for optimized builds without sanitizers";
#endif
  const std::filesystem::path build = ALIDADE_BUILD_FOLDER;
  std::vector<std::filesystem::path> files = {build / "alidade"};
  std::error_code error;
  for (const char* const folder_name : {"", "postgres", "python/alidade"})
    for (const auto& entry : std::filesystem::directory_iterator(build / folder_name, error))
      if (entry.path().extension() == ".so" || entry.path().extension() == ".duckdb_extension")
        files.push_back(entry.path());
  for (const std::filesystem::path& file : files) {
    // It copies into no buffer of known size.
    if (file.filename() == "alidade_openimageio.so") continue;
    const std::string symbols = shell_output("readelf --dyn-syms -W '" + file.string() + "'", folder);
    if (symbols.empty()) GTEST_SKIP() << "readelf of Debian's binutils is not there";
    EXPECT_TRUE(contains(symbols, "__memcpy_chk")) << file;
  }
}

}  // namespace
}  // namespace alidade::test
