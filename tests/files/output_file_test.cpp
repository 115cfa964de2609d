#include "files/output_file.hpp"

#include <gtest/gtest.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

namespace fs = std::filesystem;

// An empty folder of the test's own.
class AnOutputFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("output_file_" + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path() const { return (folder_ / "result.txt").string(); }
  long files() const {
    return std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  }
  std::string content() const {
    std::ifstream in(path(), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }

  fs::path folder_;
};

TEST_F(AnOutputFile, ExistsOnceItIsCommitted) {
  {
    OutputFile file(path());
    file.stream() << "first\n" << 2;
    EXPECT_FALSE(fs::exists(path()));
    file.commit();
    EXPECT_TRUE(fs::exists(path()));
  }
  EXPECT_EQ(content(), "first\n2");
  EXPECT_EQ(files(), 1);
}

TEST_F(AnOutputFile, LeavesNothingBehindUnlessCommitted) {
  {
    OutputFile file(path());
    file.stream() << "half a";
  }
  EXPECT_EQ(files(), 0);
}

TEST_F(AnOutputFile, OfAKilledProgramIsNotCreated) {
  if (::open(folder_.c_str(), O_TMPFILE | O_WRONLY, 0600) < 0) GTEST_SKIP() << "this file system has no files without a name";
  const pid_t child = ::fork();
  if (child == 0) {
    OutputFile file(path());
    file.stream() << std::string(100000, 'x') << std::flush;
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(files(), 0);
}

TEST_F(AnOutputFile, KeepsTheOldContentUntilItIsCommitted) {
  write_file(path(), "old");
  {
    OutputFile file(path());
    file.stream() << "new";
    file.stream().flush();
    EXPECT_EQ(content(), "old");
  }
  EXPECT_EQ(content(), "old");
  write_file(path(), "new");
  EXPECT_EQ(content(), "new");
  EXPECT_EQ(files(), 1);
}

TEST_F(AnOutputFile, KeepsEveryByteUnchanged) {
  const std::string bytes("a\r\n\0\xff z", 7);
  write_file(path(), bytes);
  EXPECT_EQ(content(), bytes);
}

TEST_F(AnOutputFile, NamesThePlaceThatCannotBeWritten) {
  const std::string nowhere = (folder_ / "missing" / "result.txt").string();
  try {
    OutputFile file(nowhere);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const InvalidInput& e) {
    EXPECT_NE(std::string(e.what()).find(nowhere), std::string::npos) << e.what();
  }
  EXPECT_THROW(OutputFile("-"), InvalidInput);  // no file of that name, and no terminal
  EXPECT_FALSE(fs::exists("-"));
  fs::create_directory(path());
  EXPECT_THROW(write_file(path(), "text"), InvalidInput);
  EXPECT_TRUE(fs::is_directory(path()));
  EXPECT_EQ(files(), 1);
}

// A limit on the size of files stands in for a full disk.
TEST_F(AnOutputFile, KeepsTheOldContentWhenTheDiskIsFull) {
  write_file(path(), "old");
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{1024, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  EXPECT_THROW(write_file(path(), std::string(100000, 'x')), InvalidInput);
  EXPECT_THROW(write_file(path(), std::string(1500, 'x')), InvalidInput);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(content(), "old");
  EXPECT_EQ(files(), 1);
}

}  // namespace
}  // namespace veridyn
