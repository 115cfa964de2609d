#include "recordings/rows_on_disk.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "cli/tool.hpp"
#include "recordings/kept_recordings.hpp"

// Rows that are read back from the disk are those of the text, to the last bit.

namespace veridyn {
namespace {

constexpr double kGap = std::numeric_limits<double>::quiet_NaN();

// Sets TMPDIR for one test.
class TemporaryFilesIn {
 public:
  explicit TemporaryFilesIn(const std::string& folder) {
    if (const char* before = std::getenv("TMPDIR")) before_ = before;
    ::setenv("TMPDIR", folder.c_str(), 1);
  }
  ~TemporaryFilesIn() { before_ ? ::setenv("TMPDIR", before_->c_str(), 1) : ::unsetenv("TMPDIR"); }
  TemporaryFilesIn(const TemporaryFilesIn&) = delete;
  TemporaryFilesIn& operator=(const TemporaryFilesIn&) = delete;

 private:
  std::optional<std::string> before_;
};

bool same_numbers(const double* a, const double* b, Eigen::Index count) {
  return std::memcmp(a, b, static_cast<size_t>(count) * sizeof(double)) == 0;
}

class RowsReadBack : public testing::Test {
 protected:
  RowsReadBack() : path_(folder_.path("r.csv")) {
    Recording r;
    r.time = VectorXd::LinSpaced(kRows, 0.0, 9.99);
    r.q = MatrixXd::Random(kRows, 2);
    r.tau = MatrixXd::Random(kRows, 2);
    r.q(7, 1) = kGap;
    write_recording(r, path_);
    text_ = read_recording(path_);
  }

  // Reads the file in pieces of these sizes, the last of them again and again, and compares it with
  // the text. Returns the number of files that were parsed.
  long parsed(KeptRecordings& kept, const std::vector<int>& sizes, const RecordingOptions& how = {}) {
    const long before = files_parsed();
    const OpenedRows rows = open_rows(path_, how, &kept);
    int at = 0;
    for (size_t k = 0; at < kRows; k = std::min(k + 1, sizes.size() - 1)) {
      const Recording piece = rows.next(sizes[k]);
      if (piece.rows() == 0) break;
      EXPECT_EQ(piece.source, path_);
      EXPECT_EQ(piece.dq.size(), 0);
      const Recording expected = rows_of(text_, at, piece.rows());
      EXPECT_TRUE(same_numbers(piece.time.data(), expected.time.data(), piece.rows()));
      EXPECT_TRUE(same_numbers(piece.q.data(), expected.q.data(), expected.q.size()));
      EXPECT_TRUE(same_numbers(piece.tau.data(), expected.tau.data(), expected.tau.size()));
      at += piece.rows();
    }
    EXPECT_EQ(at, std::min<long>(kRows, how.row_count.value_or(kRows)));
    EXPECT_EQ(rows.next(10).rows(), 0);
    EXPECT_EQ(rows.facts().format, "CSV");
    return files_parsed() - before;
  }

  static constexpr int kRows = 1000;
  TemporaryFolder folder_;
  std::string path_;
  Recording text_;
};

TEST_F(RowsReadBack, AreParsedOnceForAnyPieceSize) {
  KeptRecordings kept(0);  // nothing stays in memory
  EXPECT_EQ(parsed(kept, {300}), 1);
  for (const std::vector<int>& sizes : {std::vector<int>{300}, {1000}, {2000}, {7, 450, 1}, {299, 2}})
    EXPECT_EQ(parsed(kept, sizes), 0);
  RecordingOptions many;
  many.row_count = 5000;
  EXPECT_EQ(parsed(kept, {4096}, many), 0);
}

TEST_F(RowsReadBack, AreParsedAgainForAnotherSelection) {
  KeptRecordings kept(0);
  RecordingOptions some;
  some.row_count = 600;
  EXPECT_EQ(parsed(kept, {250}, some), 1);
  EXPECT_EQ(parsed(kept, {250}), 1);        // the first 600 are not the recording
  EXPECT_EQ(parsed(kept, {250}, some), 1);  // nor is the recording the first 600
  EXPECT_EQ(parsed(kept, {250}), 0);
}

TEST_F(RowsReadBack, AreParsedEveryTimeWhereNoFileCanBeWritten) {
  const TemporaryFilesIn nowhere(folder_.path("no-such-folder"));
  KeptRecordings kept(0);
  EXPECT_EQ(parsed(kept, {300}), 1);
  EXPECT_EQ(parsed(kept, {300}), 1);
}

TEST_F(RowsReadBack, LeaveNoTemporaryFile) {
  const TemporaryFilesIn here(folder_.path(""));
  KeptRecordings kept(0);
  EXPECT_EQ(parsed(kept, {300}), 1);
  EXPECT_EQ(parsed(kept, {300}), 0);
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path(""))) files += entry.is_regular_file();
  EXPECT_EQ(files, 1) << "the recording alone";
}

}  // namespace
}  // namespace veridyn
