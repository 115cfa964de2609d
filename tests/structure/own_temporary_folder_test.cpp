#include <gtest/gtest.h>

#include <filesystem>

namespace veridyn {
namespace {

namespace fs = std::filesystem;

// Both ways to a temporary folder lead to one that is this process's own, see tests/support/own_temporary_folder.cpp.
TEST(TemporaryFolder, IsEmptyAndBelongsToThisProcess) {
  const fs::path folder = fs::temp_directory_path();
  EXPECT_TRUE(fs::equivalent(testing::TempDir(), folder));
  EXPECT_EQ(folder.filename().string().rfind("veridyn-test-", 0), 0U) << folder;
  EXPECT_TRUE(fs::is_empty(folder)) << "another process writes there";
}

}  // namespace
}  // namespace veridyn
