#include "veridyn/recordings/recording.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// A file with the given content, removed at the end of the test.
class RecordingFile : public testing::Test {
 protected:
  void SetUp() override {
    path_ = testing::TempDir() + "veridyn-recording-" + std::to_string(::getpid()) + ".csv";
  }
  void TearDown() override { std::remove(path_.c_str()); }

  Recording read(const std::string& content, const RecordingOptions& options = {}) const {
    std::ofstream(path_, std::ios::binary) << content;
    return read_recording(path_, options);
  }

  // The message of the error that reading ends with, without the path; "" if it does not.
  std::string error_of(const std::string& content, const RecordingOptions& options = {}) const {
    try {
      read(content, options);
    } catch (const InvalidInput& error) {
      std::string message = error.what();
      if (message.rfind(path_, 0) == 0) message = message.substr(path_.size());
      return message;
    }
    return "";
  }

  std::string path_;
};

using AGoodFile = RecordingFile;
using ABadFile = RecordingFile;

TEST_F(AGoodFile, ColumnsAreReadByNameInAnyOrderAndOthersIgnored) {
  const Recording r = read(
      "tau2,note,t,q1,q2,dq2,dq1,tau1,itarget1\n"
      "22,a comment,0,1,2,12,11,21,x\n"
      "23,\"one, two\",0.5,3,4,14,13,22,y\n");
  ASSERT_EQ(r.rows(), 2);
  ASSERT_EQ(r.joints(), 2);
  EXPECT_EQ(r.time[1], 0.5);
  EXPECT_EQ(r.q(1, 0), 3.0);
  EXPECT_EQ(r.q(1, 1), 4.0);
  EXPECT_EQ(r.dq(0, 0), 11.0);
  EXPECT_EQ(r.dq(0, 1), 12.0);
  EXPECT_EQ(r.tau(1, 0), 22.0);
  EXPECT_EQ(r.tau(1, 1), 23.0);
  EXPECT_EQ(r.ddq.size(), 0);
  EXPECT_EQ(r.current.size(), 0);
}

TEST_F(AGoodFile, EverySeparatorAndLineEndGivesTheSameRecording) {
  for (const std::string content :
       {"t,q1,tau1\n0,1,2\n1,+3e0,-4\n", "t;q1;tau1\n0;1;2\n1;3;-4\n",
        "t\tq1\ttau1\n0\t1\t2\n1\t3\t-4\n", "t q1   tau1\n 0 1 2\n1  3 -4  \n",
        "\xEF\xBB\xBFt,q1,tau1\r\n0,1,2\r\n1,3,-4\r\n",
        "\"t\", 'q1' ,\"tau1\"\n\n# a remark\n0, 1 , 2\n1,\"3\",-4",
        "# t,q1,tau1\n0,1,2\n1,3,-4\n"}) {
    SCOPED_TRACE(content);
    const Recording r = read(content);
    ASSERT_EQ(r.rows(), 2);
    EXPECT_EQ(r.time[1], 1.0);
    EXPECT_EQ(r.q(1, 0), 3.0);
    EXPECT_EQ(r.tau(1, 0), -4.0);
  }
}

TEST_F(AGoodFile, EmptyFieldsAndNanAreGaps) {
  const Recording r = read("t,q1,q2,dq1,dq2\n0,,nan,NaN, \n1,nan,nan,,\n2,1,1,1,\n");
  ASSERT_EQ(r.rows(), 3);
  EXPECT_TRUE(r.q.topRows(2).array().isNaN().all());
  EXPECT_TRUE(std::isnan(r.dq(2, 1)));
  EXPECT_EQ(r.dq(2, 0), 1.0);
}

// As spreadsheets and data bases write what is missing.
TEST_F(AGoodFile, WordsForMissingValuesAreGaps) {
  const Recording r = read("t,q1,tau1\n0,null,#N/A\n1,-,None\n2,1,2\n");
  EXPECT_TRUE(r.q.topRows(2).array().isNaN().all() && r.tau.topRows(2).array().isNaN().all());
  EXPECT_EQ(r.tau(2, 0), 2.0);
  EXPECT_THROW(read("t,q1\n0,nothing\n"), InvalidInput);
}

TEST_F(AGoodFile, TheTimeOfARowWithoutNumbersIsInterpolated) {
  const Recording r = read("t,q1\n0,5\nnan,nan\n,\n3,8\nnan,\n");
  ASSERT_EQ(r.rows(), 4);
  EXPECT_NEAR(r.time[1], 1.0, 1e-15);
  EXPECT_NEAR(r.time[2], 2.0, 1e-15);
  EXPECT_TRUE(std::isnan(r.q(1, 0)) && std::isnan(r.q(2, 0)));
  EXPECT_EQ(r.q(3, 0), 8.0);
}

TEST_F(AGoodFile, AbsurdAndInfiniteNumbersAreReadAsTheyAre) {
  const Recording r = read("t,q1,q2\n0,1e305,-inf\n1,1e999,1e-999\n2,0,0\n");
  EXPECT_EQ(r.q(0, 0), 1e305);
  EXPECT_EQ(r.q(0, 1), -INFINITY);
  EXPECT_EQ(r.q(1, 0), INFINITY);
  EXPECT_EQ(r.q(1, 1), 0.0);
}

TEST_F(AGoodFile, ARecordingOfZerosIsRead) {
  const Recording r = read("t,q1,dq1,tau1\n0,0,0,0\n1,0,0,0\n");
  EXPECT_EQ(r.tau.norm(), 0.0);
}

TEST_F(AGoodFile, WithoutAHeaderTheOptionsNameTheColumns) {
  RecordingOptions options;
  options.columns = {"q", "tau"};
  options.rate = 4.0;
  const Recording r = read("1,2,11,12\n3,4,13,14\n", options);
  ASSERT_EQ(r.joints(), 2);
  EXPECT_EQ(r.time[1], 0.25);
  EXPECT_EQ(r.q(1, 1), 4.0);
  EXPECT_EQ(r.tau(1, 0), 13.0);

  options.columns = {"t", "q", "dq", "i"};
  options.rate = 0.0;
  const Recording timed = read("0 1 2 3\n0.1 4 5 6\n", options);
  EXPECT_EQ(timed.time[1], 0.1);
  EXPECT_EQ(timed.current(1, 0), 6.0);

  options.columns = {"t", "q1", "tau1", "q2", "tau2"};
  const Recording by_joint = read("0 1 11 2 12\n0.1 3 13 4 14\n", options);
  ASSERT_EQ(by_joint.joints(), 2);
  EXPECT_EQ(by_joint.q(1, 1), 4.0);
  EXPECT_EQ(by_joint.tau(1, 0), 13.0);
  EXPECT_THROW(read("0 1 11 2\n0.1 3 13 4\n", options), InvalidInput);
}

TEST_F(AGoodFile, SelectedRowsEqualThoseOfTheWholeFile) {
  std::string content = "t,q1\n";
  for (int k = 0; k < 100; ++k) content += text(k, ",", 2 * k, "\n");
  const Recording whole = read(content);
  for (const long first : {0L, 1L, 42L, 99L}) {
    RecordingOptions options;
    options.first_row = first;
    options.row_count = 7;
    const Recording part = read(content, options);
    const int rows = static_cast<int>(std::min(7L, 100 - first));
    ASSERT_EQ(part.rows(), rows);
    EXPECT_EQ(part.time, whole.time.segment(first, rows));
    EXPECT_EQ(part.q, whole.q.middleRows(first, rows));
  }
}

TEST_F(AGoodFile, ASelectionMayEndWithinAGap) {
  RecordingOptions options;
  options.row_count = 3;
  const Recording r = read("t,q1\n0,5\n1,6\n,\n,\n4,8\n", options);
  ASSERT_EQ(r.rows(), 3);
  EXPECT_EQ(r.time[2], 2.0);
}

TEST_F(AGoodFile, SelectedRowsKeepTheirTimes) {
  RecordingOptions options;
  options.columns = {"q"};
  options.rate = 10.0;
  options.first_row = 2;
  EXPECT_EQ(read("1\n2\n3\n4\n", options).time[0], 0.2);
}

TEST_F(AGoodFile, ReadingInPiecesOfAnySizeGivesTheWholeFile) {
  std::string content = "t,q1,q2\n";
  for (int k = 0; k < 257; ++k)
    content += k % 50 == 7 ? ",,\n" : text(k * 0.01, ",", std::sin(k), ",", k, "\n");
  const Recording whole = read(content);
  for (const int size : {1, 3, 64, 257, 1000}) {
    RecordingReader reader(path_);
    EXPECT_EQ(reader.joints(), 2);
    int row = 0;
    for (Recording piece = reader.next(size); piece.rows() > 0; piece = reader.next(size)) {
      ASSERT_LE(row + piece.rows(), whole.rows());
      EXPECT_EQ(piece.time, whole.time.segment(row, piece.rows()));
      EXPECT_EQ(piece.q.col(1).array().isNaN().count(),
                whole.q.col(1).segment(row, piece.rows()).array().isNaN().count());
      row += piece.rows();
    }
    EXPECT_EQ(row, 257);
  }
}

// Longer than the read buffer, so that lines are cut by its end.
TEST_F(AGoodFile, ALongFileIsReadToItsEnd) {
  constexpr int kRows = 90000;
  {
    std::ofstream file(path_);
    file << "t,q1,tau1\n";
    for (int k = 0; k < kRows; ++k)
      file << k << "," << 0.001 * k << "," << (k % 977) * 0.125 << "\n";
  }
  const Recording r = read_recording(path_);
  ASSERT_EQ(r.rows(), kRows);
  for (int k = 0; k < kRows; ++k) {
    ASSERT_EQ(r.time[k], k);
    ASSERT_EQ(r.tau(k, 0), (k % 977) * 0.125);
  }
}

TEST_F(AGoodFile, AWrittenFileIsReadBackToNineDigits) {
  Recording r;
  const int rows = 300;
  r.time = VectorXd::LinSpaced(rows, 0.0, 1234.567);
  r.q = MatrixXd::Random(rows, 3) * 1e-4;
  r.dq = MatrixXd::Random(rows, 3);
  r.ddq = MatrixXd::Random(rows, 3) * 1e8;
  r.tau = MatrixXd::Random(rows, 3);
  r.current = MatrixXd::Random(rows, 3);
  r.q(7, 1) = NAN;
  write_recording(r, path_);
  const Recording back = read_recording(path_);
  ASSERT_EQ(back.rows(), rows);
  EXPECT_LE((back.time - r.time).cwiseAbs().maxCoeff(), 1e-11 * 1234.567);
  EXPECT_TRUE(std::isnan(back.q(7, 1)));
  for (const RecordingSignal& signal : kRecordingSignals) {
    const MatrixXd& wrote = r.*signal.values;
    const MatrixXd& read_back = back.*signal.values;
    for (int j = 0; j < 3; ++j) {
      for (int k = 0; k < rows; ++k) {
        if (std::isnan(wrote(k, j))) continue;
        ASSERT_NEAR(read_back(k, j), wrote(k, j), 1e-9 * std::abs(wrote(k, j)));
      }
    }
  }
}

TEST_F(AGoodFile, SignalsOfUnequalSizeAreNotWritten) {
  Recording r;
  r.time = VectorXd::LinSpaced(5, 0.0, 1.0);
  r.q = MatrixXd::Zero(5, 2);
  r.tau = MatrixXd::Zero(4, 2);
  EXPECT_THROW(write_recording(r, path_), InvalidInput);
  EXPECT_NE(::access(path_.c_str(), F_OK), 0);
}

// ---- files that cannot be used: the whole message, so that it stays worth reading

TEST_F(ABadFile, ThatDoesNotExistIsNamed) {
  try {
    read_recording("/no/such/file.csv");
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_STREQ(error.what(),
                 "/no/such/file.csv: found no such file, expected a recording.");
  }
  EXPECT_THROW(read_recording(testing::TempDir()), InvalidInput);
}

TEST_F(ABadFile, ThatMayNotBeReadIsNamed) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may read everything";
  std::ofstream(path_) << "t,q1\n0,1\n";
  ::chmod(path_.c_str(), 0);
  EXPECT_THROW(read_recording(path_), InvalidInput);
}

TEST_F(ABadFile, WithoutContentIsNamed) {
  EXPECT_EQ(error_of(""), ": found an empty file, expected a recording (CSV).");
  EXPECT_EQ(error_of("\n# nothing\n"), ": found no row, expected a header and numbers.");
  EXPECT_EQ(error_of("t,q1\n"), ": found a header without rows, expected numbers below it.");
  EXPECT_EQ(error_of(std::string("\x7f"
                                 "ELF\0\0\0\0",
                                 8)),
            ": found binary data, expected text (CSV), or a whole bag, MCAP, .npz, .mat or HDF5 "
            "file.");
}

TEST_F(ABadFile, WithoutAHeaderIsRefusedWithTheOptionForColumns) {
  EXPECT_EQ(error_of("0,1,2\n1,2,3\n"),
            ":1: found numbers, expected a header; the first line is numbers, so name them with "
            "--columns and --rate.");
}

TEST_F(ABadFile, WithABadColumnsOptionIsRefusedWithTheReason) {
  RecordingOptions options;
  options.columns = {"q", "tau"};
  EXPECT_EQ(error_of("1,2\n", options), ":1: found no column t, expected one, or --rate.");
  options.rate = 100.0;
  EXPECT_EQ(error_of("1,2,3\n", options),
            ":1: found 3 columns, expected the same number of joints for each of the 2 signals of "
            "--columns.");
  EXPECT_EQ(error_of("q1,tau1\nrad,Nm\n1,2\n", options),
            ":2: found text in the second line, too, expected numbers.");
  options.columns = {"q", "torque"};
  EXPECT_EQ(error_of("1,2\n", options),
            "--columns: found 'torque', expected q, dq, ddq, tau or i (t only as the first).");
  options.columns = {"tau"};
  EXPECT_EQ(error_of("1,2\n", options),
            "--columns: found no q, expected positions among the signals.");
}

TEST_F(ABadFile, WithRaggedRowsNamesTheLine) {
  EXPECT_EQ(error_of("t,q1,tau1\n0,1,2\n1,2\n"), ":3: found 2 fields, expected 3.");
  EXPECT_EQ(error_of("t,q1,tau1\n0,1,2\n1,2,3,4\n"), ":3: found 4 fields, expected 3.");
  EXPECT_EQ(error_of("t,q1,x\n0,1,a\n1,2\n"), ":3: found 2 fields, expected 3.");
  EXPECT_EQ(error_of("t q1 tau1\n0 1 2\n1 2\n"), ":3: found 2 fields, expected 3.");
}

TEST_F(ABadFile, WithTextInANumberNamesLineAndColumn) {
  EXPECT_EQ(error_of("t,q1,tau1\n0,1,2\n\n1,2,abc\n"),
            ":4:3: found 'abc' in column tau1, expected a number.");
  EXPECT_EQ(error_of("t,q1,tau1\n0,1.5.2,2\n"),
            ":2:2: found '1.5.2' in column q1, expected a number.");
  EXPECT_EQ(error_of("t;q1\n0;1,5,2\n"), ":2:2: found '1,5,2' in column q1, expected a number.");
  EXPECT_EQ(error_of("t,q1,tau1\n0,1 2,3\n"), ":2:2: found '1 2' in column q1, expected a number.");
  EXPECT_EQ(error_of("t,q1\n0,0x1f\n"), ":2:2: found '0x1f' in column q1, expected a number.");
}

TEST_F(ABadFile, WhoseTimeRunsBackIsRefusedWithBothTimes) {
  EXPECT_EQ(error_of("q1,t\n1,0\n2,1\n9,0.5\n"),
            ":4:2: found time 0.5 s after 1 s, expected it to grow; a second recording begins at row 2: --rows 0:2 reads what is "
            "before it, --rows 2: the rest, and --rate HZ counts the rows instead.");
  EXPECT_EQ(error_of("t,q1\n0,1\n,2\n1,3\n"),
            ":3: found no time in a row with numbers, expected a time in seconds.");
  EXPECT_EQ(error_of("t,q1\n0,1\ninf,2\n"),
            ":3: found infinite time in a row with numbers, expected a time in seconds.");
}

TEST_F(ABadFile, WithAMisspeltHeaderSuggestsTheRightName) {
  EXPECT_EQ(error_of("t,q1,q2,tua1,tua2\n"),
            ":1:4: found column 'tua1' and no tau, expected 'tau1' (rename the column if it is "
            "something else).");
}

TEST_F(AGoodFile, MayUseAlternativeSignalNames) {
  for (const std::string name : {"Q1", "q_1", "position1", "qpos[0]"})
    EXPECT_EQ(read("t," + name + "\n0,1\n1,2\n").q(1, 0), 2.0) << name;
  for (const std::string name : {"torque_1", "effort1", "TAU1"})
    EXPECT_EQ(read("t,q1," + name + "\n0,1,5\n1,2,6\n").tau(1, 0), 6.0) << name;
  EXPECT_EQ(read("t,q1,qd1\n0,1,5\n1,2,6\n").dq(1, 0), 6.0);
  EXPECT_EQ(read("time,q1\n0,1\n0.5,2\n").time[1], 0.5);
}

TEST_F(AGoodFile, MayRepeatATimeStampWhichIsRemarked) {
  std::ofstream(path_) << "t,q1\n0,1\n0.01,2\n0.01,3\n0.02,4\n";
  RecordingReader reader(path_);
  const Recording r = reader.next(10);
  ASSERT_EQ(r.rows(), 4);
  EXPECT_EQ(r.time[2], 0.015);
  ASSERT_EQ(reader.facts().remarks.size(), 1u);
  EXPECT_EQ(reader.facts().remarks[0], "1 row repeats the time stamp before with other values: such rows are spread evenly up to the next time.");
  std::ofstream(path_) << "t,q1\n0,1\n0.01,2\n0.01,2\n0.02,4\n";
  RecordingReader twice(path_);
  EXPECT_EQ(twice.next(10).rows(), 3);
  EXPECT_EQ(twice.facts().remarks[0], "1 row repeats the time stamp before and is left out.");
  RecordingOptions as_recorded;
  as_recorded.signals.as_recorded = true;
  std::ofstream(path_) << "t,q1\n0,1\n0.01,2\n0.01,3\n0.02,4\n";
  EXPECT_EQ(RecordingReader(path_, as_recorded).next(10).rows(), 3);
}

TEST_F(AGoodFile, MayHaveADecimalComma) {
  const Recording r = read("t;q1;tau1\n0,0;1,5;-2\n0,01;1,75;\"3,25\"\n");
  EXPECT_EQ(r.time[1], 0.01);
  EXPECT_EQ(r.q(1, 0), 1.75);
  EXPECT_EQ(r.tau(1, 0), 3.25);
}

TEST_F(ABadFile, WithAnInvalidHeaderReportsTheReason) {
  EXPECT_EQ(error_of("t,a,b\n0,1,2\n"),
            ":1: found columns t, a, b, expected a header with t and q1 to qn.");
  EXPECT_EQ(error_of("t,q1,q3\n0,1,2\n"),
            ":1: found q3 but no q2, expected joints without a hole (q1 to qn).");
  EXPECT_EQ(error_of("t,q0,q1\n0,1,2\n"),
            ":1: found q0, expected joints to count from 1 (q1, q2, ...).");
  EXPECT_EQ(error_of("t,q1,q1\n0,1,2\n"), ":1: found column q1 twice, expected it once: rename the one that is not to be used.");
  EXPECT_EQ(error_of("t,q1,q2,tau1\n0,1,2,3\n"),
            ":1: found 2 joints in q but 1 in tau, expected the same number in each signal.");
  EXPECT_EQ(error_of("q1,q2\n1,2\n"), ":1: found no column t, expected one, or --rate.");
}

TEST_F(ABadFile, WithTooFewRowsForTheSelectionIsRefusedWithTheReason) {
  RecordingOptions options;
  options.first_row = 5;
  EXPECT_EQ(error_of("t,q1\n0,1\n1,2\n", options),
            ": found no row from row 5 on, expected some in --rows.");
}

}  // namespace
}  // namespace veridyn
