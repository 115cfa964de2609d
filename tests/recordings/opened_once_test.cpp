#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <sstream>
#include <thread>

#include "recordings/files/byte_stream.hpp"
#include "recordings/files/whole_file.hpp"
#include "recordings/kept_recordings.hpp"
#include "recordings/samples.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/recordings/recording.hpp"

// What a file is, its header and its rows are found in one opening of it.

namespace veridyn {
namespace {

const std::string kPlain = "t,q1,tau1\n0,1,5\n0.1,2,6\n0.2,3,7\n";
const std::string kTable = "time,elbow_position,elbow_effort\n0,1,5\n0.1,2,6\n0.2,3,7\n";

class Opened : public testing::Test {
 protected:
  void SetUp() override {
    path_ = testing::TempDir() + "veridyn-opened-" + std::to_string(::getpid()) + ".csv";
  }
  void TearDown() override { std::remove(path_.c_str()); }

  void write(const std::string& content) const {
    std::ofstream(path_, std::ios::binary) << content;
  }

  std::string path_;
};

long opened_by_reading(const std::string& path) {
  const long before = files_opened();
  EXPECT_GT(read_recording(path).rows(), 0) << path;
  return files_opened() - before;
}

TEST_F(Opened, EveryReadOpensTheFileOnce) {
  for (const std::string& content : {kPlain, kTable}) {
    write(content);
    EXPECT_EQ(opened_by_reading(path_), 1);
    EXPECT_EQ(opened_by_reading(path_), 1);
  }
}

// The bound holds for the sum of all files, not for each.
TEST_F(Opened, FilesAreKeptInMemoryUpToABoundInTotal) {
  write(kPlain);
  const std::string other = path_ + ".other.csv";
  std::ofstream(other, std::ios::binary) << kPlain;
  const auto size = static_cast<long>(kPlain.size());
  KeptRecordings both(2 * size), one(2 * size - 1);
  for (KeptRecordings* kept : {&both, &one}) EXPECT_NE(kept->find(path_, {}), nullptr);
  EXPECT_NE(both.find(other, {}), nullptr);
  EXPECT_EQ(one.find(other, {}), nullptr);
  EXPECT_NE(one.find(path_, {}), nullptr);
  std::remove(other.c_str());
}

// A file that cannot be parsed takes no room from the next one.
TEST_F(Opened, AnUnreadableFileTakesNoMemoryFromTheNextOne) {
  const std::string bad = path_ + ".bad.csv";
  write(kPlain);
  std::ofstream(bad, std::ios::binary) << "t,q1,tau1\n0,1,x\n";
  KeptRecordings kept(static_cast<long>(kPlain.size()));
  EXPECT_THROW(kept.find(bad, {}), InvalidInput);
  EXPECT_NE(kept.find(path_, {}), nullptr);
  std::remove(bad.c_str());
}

TEST_F(Opened, BagsAndArraysAreOpenedOnce) {
  for (const char* name : {"ros1_lz4.bag", "mcap_cdr_zstd.mcap", "numpy.npz"})
    EXPECT_EQ(opened_by_reading(sample(name)), 1) << name;
}

// A mapped file would end the program with SIGBUS here.
TEST_F(Opened, AFileTruncatedByAnotherProgramKeepsItsBytesInMemory) {
  const std::string content(3 << 20, 'x');
  write(content);
  const WholeFile file(path_);
  write("");
  EXPECT_EQ(file.bytes(), content);
}

// Files of the kernel have fewer bytes than their size says, as one has that is cut in between.
TEST_F(Opened, AFileShorterThanItsStatedSizeIsRefused) {
  const std::string path = "/sys/kernel/mm/transparent_hugepage/enabled";
  struct stat about {};
  if (::stat(path.c_str(), &about) != 0 || about.st_size < 1000) GTEST_SKIP() << "no " << path;
  try {
    const WholeFile file(path);
    FAIL() << "read";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("another program cuts it"), std::string::npos) << error.what();
  }
}

TEST_F(Opened, AFileThatIsKeptIsOpenedOnceForAllItsReaders) {
  write(kPlain);
  KeptRecordings kept;
  RecordingOptions first_two;
  first_two.row_count = 2;
  RecordingOptions more_than_there_are;
  more_than_there_are.row_count = 20;
  const long before = files_opened();
  EXPECT_EQ(open_rows(path_, {}, &kept).next(100).rows(), 3);
  EXPECT_EQ(open_rows(path_, more_than_there_are, &kept).next(100).rows(), 3);
  EXPECT_EQ(read_rows(path_, first_two, &kept).rows(), 2);
  EXPECT_EQ(files_opened() - before, 1);
}

TEST_F(Opened, SelectedRowsOfAKeptFileEqualThoseOfTheFile) {
  write(kPlain);
  KeptRecordings kept;
  for (const long first : {0, 1, 2}) {
    for (const long count : {-1, 1, 5}) {
      RecordingOptions options;
      options.first_row = first;
      if (count >= 0) options.row_count = count;
      const Recording of_file = read_recording(path_, options);
      for (const Recording& r :
           {read_rows(path_, options, &kept), open_rows(path_, options, &kept).next(100)}) {
        ASSERT_EQ(r.rows(), of_file.rows()) << first << " " << count;
        EXPECT_EQ(r.q, of_file.q) << first << " " << count;
      }
    }
  }
}

TEST_F(Opened, ARecordingIsCheckedOncePerSetOfOptions) {
  KeptRecordings kept;
  int judged = 0;
  const auto judge = [&] {
    RecordingQuality quality;
    quality.rows = ++judged;
    return quality;
  };
  RecordingOptions two_rows;
  two_rows.row_count = 2;
  EXPECT_EQ(kept.quality("a.csv", {}, judge).rows, 1);
  EXPECT_EQ(kept.quality("a.csv", {}, judge).rows, 1);
  EXPECT_EQ(kept.quality("a.csv", two_rows, judge).rows, 2);
  EXPECT_EQ(kept.quality("b.csv", {}, judge).rows, 3);
}

// Nothing of a pipe can be read twice.
TEST_F(Opened, APipeGivesTheSameRecordingAsAFile) {
  for (const std::string& content : {kPlain, kTable}) {
    write(content);
    const Recording of_file = read_recording(path_);
    std::remove(path_.c_str());
    ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
    std::thread writer([&] { write(content); });
    const Recording of_pipe = read_recording(path_);
    writer.join();
    std::remove(path_.c_str());
    ASSERT_EQ(of_pipe.rows(), of_file.rows()) << content;
    EXPECT_EQ(of_pipe.q, of_file.q) << content;
    EXPECT_EQ(of_pipe.time, of_file.time) << content;
  }
}

TEST_F(Opened, APipeIsKeptInMemoryForAllItsReaders) {
  write(kPlain);
  const Recording of_file = read_recording(path_);
  std::remove(path_.c_str());
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  std::thread writer([&] { write(kPlain); });
  KeptRecordings kept(0);
  const Recording first = open_rows(path_, {}, &kept).next(100);
  writer.join();
  const Recording second = open_rows(path_, {}, &kept).next(100);
  for (const Recording& r : {first, second}) {
    ASSERT_EQ(r.rows(), of_file.rows());
    EXPECT_EQ(r.q, of_file.q);
  }
}

// More comments than are kept in memory while the header is looked for: the file is wound back.
TEST_F(Opened, AHeaderAfterTwoMegabytesOfCommentsIsFound) {
  std::ostringstream comments;
  for (int k = 0; k < 60000; ++k) comments << "# a line that says nothing, number " << k << "\n";
  ASSERT_GT(comments.str().size(), std::size_t{2} << 20);
  for (const std::string& content : {kPlain, kTable}) {
    write(comments.str() + content);
    EXPECT_EQ(opened_by_reading(path_), 1);
    EXPECT_EQ(read_recording(path_).q, (MatrixXd(3, 1) << 1, 2, 3).finished());
    write(comments.str() + content + "0.3,text,8\n");  // lines are counted from the first one
    try {
      read_recording(path_);
      ADD_FAILURE() << "a row of text was read";
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find(":60005:2: found 'text'"), std::string::npos)
          << error.what();
    }
  }
}

}  // namespace
}  // namespace veridyn
