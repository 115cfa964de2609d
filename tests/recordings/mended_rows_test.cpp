#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <string>

#include "veridyn/math/require.hpp"
#include "veridyn/recordings/recording.hpp"

// Rows that are plainly wrong are mended or become gaps, with a remark; --as-recorded keeps them, and a sound
// recording passes through bit by bit.
namespace veridyn {
namespace {

constexpr double kStep = 0.01;
constexpr int kMendedRows = 1200;

// Two joints that turn smoothly, with velocities and torques.
Recording smooth() {
  Recording r;
  r.time = VectorXd::LinSpaced(kMendedRows, 0.0, kStep * (kMendedRows - 1));
  for (MatrixXd* values : {&r.q, &r.dq, &r.tau}) values->resize(kMendedRows, 2);
  for (int k = 0; k < kMendedRows; ++k) {
    const double t = r.time[k];
    r.q.row(k) << 0.4 + 1.1 * std::sin(1.3 * t), -0.9 + 0.8 * std::cos(0.9 * t);
    r.dq.row(k) << 1.1 * 1.3 * std::cos(1.3 * t), -0.8 * 0.9 * std::sin(0.9 * t);
    r.tau.row(k) << 12.0 + 3.0 * std::cos(1.3 * t), -7.0 + 2.0 * std::sin(0.9 * t);
  }
  return r;
}

class AWrongRow : public testing::Test {
 protected:
  void SetUp() override { path_ = testing::TempDir() + "veridyn-mended-" + std::to_string(::getpid()) + ".csv"; }
  void TearDown() override { std::remove(path_.c_str()); }

  Recording read(const Recording& written, RecordingOptions options = {}) {
    write_recording(written, path_);
    return read_again(options);
  }

  Recording read_again(const RecordingOptions& options) {
    RecordingFacts facts;
    Recording out = read_recording(path_, options, facts);
    remarks_.clear();
    for (const std::string& remark : facts.remarks) remarks_ += remark + "\n";
    return out;
  }

  static RecordingOptions as_recorded() {
    RecordingOptions options;
    options.signals.as_recorded = true;
    return options;
  }

  // Writes the times as a function of the row sees fit.
  void write_times(const Recording& r, const std::function<std::string(int)>& time) const {
    std::ofstream file(path_);
    file << "t,q1,q2,dq1,dq2,tau1,tau2\n";
    for (int k = 0; k < r.rows(); ++k) {
      file << time(k);
      for (const MatrixXd* values : {&r.q, &r.dq, &r.tau}) file << ',' << (*values)(k, 0) << ',' << (*values)(k, 1);
      file << '\n';
    }
  }

  std::string error_of(const RecordingOptions& options) {
    try {
      read_again(options);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }

  std::string path_, remarks_;
};

// A torque far beyond its range in one row alone, or in two rows that are as far from each other, or far from those beside
// within the range; a push of several rows stays.
TEST_F(AWrongRow, WithATorqueSpikeIsInterpolated) {
  Recording r = smooth();
  for (const int k : {300, 500, 700, 701, 702}) r.tau(k, 0) += 60.0;
  r.tau(501, 0) -= 60.0;
  int lowest = 0;
  r.tau.col(0).segment(100, 150).minCoeff(&lowest);
  lowest += 100;
  r.tau(lowest, 0) += 7.0;
  const Recording mended = read(r);
  EXPECT_NEAR(mended.tau(300, 0), smooth().tau(300, 0), 1e-3);
  EXPECT_NEAR(mended.tau(lowest, 0), smooth().tau(lowest, 0), 1e-3);
  for (const int k : {500, 501}) EXPECT_NEAR(mended.tau(k, 0), smooth().tau(k, 0), 1e-2);
  EXPECT_NEAR(mended.tau(701, 0), r.tau(701, 0), 1e-6);
  EXPECT_NE(remarks_.find("tau1 jumps out of its range in 4 rows"), std::string::npos) << remarks_;
  EXPECT_NEAR(read(r, as_recorded()).tau(300, 0), r.tau(300, 0), 1e-6);
}

TEST_F(AWrongRow, IsNotReportedForACorrectRecording) {
  const Recording r = smooth();
  const Recording plain = read(r, as_recorded()), mended = read(r);
  EXPECT_EQ(remarks_, "");
  EXPECT_EQ(plain.time, mended.time);
  EXPECT_EQ(plain.q, mended.q);
  EXPECT_EQ(plain.tau, mended.tau);
}

// Rows that were lost twice within a second, with times that are counted on: the joints jump on with their motion, which does
// not turn meanwhile, and no row between is wrong.
TEST_F(AWrongRow, IsNotReportedWhereRowsWereLost) {
  Recording r = smooth();
  int kept = 0;
  for (int k = 0; k < kMendedRows; ++k) {
    if ((k >= 400 && k < 440) || (k >= 480 && k < 520)) continue;
    for (MatrixXd Recording::*signal : {&Recording::q, &Recording::dq, &Recording::tau}) (r.*signal).row(kept) = (r.*signal).row(k).eval();
    ++kept;
  }
  r = rows_of(r, 0, kept);
  EXPECT_LT((read(r).q - r.q).cwiseAbs().maxCoeff(), 1e-8) << remarks_;
  EXPECT_EQ(remarks_, "");
}

// Encoders that read zero for some rows, also one row behind the other, and rows of another publisher in between.
TEST_F(AWrongRow, InAShortDropoutIsInterpolatedOrBecomesAGap) {
  Recording r = smooth();
  for (const int at : {100, 103, 400, 700, 705, 1100}) r.q.row(at).setZero();
  r.q.block(800, 1, 7, 1).setZero();
  const Recording sound = smooth();
  EXPECT_LT((read(r).q - sound.q).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_NE(remarks_.find("come back 7 times: 13 rows are filled in"), std::string::npos) << remarks_;
  r.dq.resize(0, 0);
  const Recording mended = read(r);
  for (int k = 0; k < kMendedRows; ++k) {
    const bool gap = k == 100 || k == 103 || k == 400 || k == 700 || k == 705 || k == 1100 || (k >= 800 && k < 807);
    EXPECT_EQ(std::isnan(mended.q(k, 1)), gap) << k;
  }
  EXPECT_NE(remarks_.find("13 rows are left out"), std::string::npos) << remarks_;
  EXPECT_EQ(read(r, as_recorded()).q.row(400).norm(), 0.0);
  EXPECT_EQ(remarks_, "");
}

TEST_F(AWrongRow, OfIsolatedZerosIsDropped) {
  const Recording r = smooth();
  Recording both;
  both.time.resize(kMendedRows + kMendedRows / 3);
  for (MatrixXd* values : {&both.q, &both.dq, &both.tau}) *values = MatrixXd::Zero(both.time.size(), 2);
  int row = 0;
  for (int k = 0; k < kMendedRows; ++k) {
    both.time[row] = r.time[k];
    both.q.row(row) = r.q.row(k);
    both.dq.row(row) = r.dq.row(k);
    both.tau.row(row++) = r.tau.row(k);
    if (k % 3 == 2) both.time[row++] = r.time[k] + 0.4 * kStep;
  }
  const Recording mended = read(both);
  ASSERT_EQ(mended.rows(), kMendedRows) << remarks_;
  EXPECT_LT((mended.q - r.q).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_NE(remarks_.find("400 rows of zeros alone amid the motion"), std::string::npos) << remarks_;
  EXPECT_EQ(read(both, as_recorded()).rows(), kMendedRows + 400);
}

// An encoder that does not answer for two seconds, with a velocity that stays as well or is zero at once.
TEST_F(AWrongRow, OfAFrozenEncoderBecomesAGap) {
  for (const bool zero : {false, true}) {
    Recording r = smooth();
    r.q.col(1).segment(500, 200).setConstant(r.q(500, 1));
    r.dq.col(1).segment(501, 199).setConstant(zero ? 0.0 : r.dq(500, 1));
    const Recording mended = read(r);
    for (int k = 0; k < kMendedRows; ++k) EXPECT_EQ(std::isnan(mended.q(k, 1)), k > 500 && k < 700) << k;
    EXPECT_TRUE(mended.q.col(0).allFinite());
    EXPECT_NE(remarks_.find("q2 and dq2 stay the same in 199 rows"), std::string::npos) << remarks_;
    EXPECT_TRUE(read(r, as_recorded()).q.allFinite());
  }
}

// A joint that brakes within a fifth of a second and rests for two.
TEST_F(AWrongRow, IsNotReportedForAJointThatRests) {
  Recording r = smooth();
  double speed = r.dq(500, 1);
  for (int k = 501; k < 720; ++k) {
    r.dq(k, 1) = speed *= k < 520 ? 0.8 : 0.0;
    r.q(k, 1) = r.q(k - 1, 1) + kStep * speed;
  }
  EXPECT_TRUE(read(rows_of(r, 0, 720)).q.allFinite()) << remarks_;
  EXPECT_EQ(remarks_, "");
}

// A step to another place for good is no dropout: the check of jumps names it.
TEST_F(AWrongRow, OfAStepThatDoesNotReturnIsKept) {
  Recording r = smooth();
  r.q.bottomRows(500).array() += 0.9;
  EXPECT_TRUE(read(r).q.allFinite());
  EXPECT_EQ(remarks_, "");
}

TEST_F(AWrongRow, WithTorquesDroppingToZeroBecomesAGap) {
  Recording r = smooth();
  r.tau.middleRows(300, 3).setZero();
  const Recording mended = read(r);
  EXPECT_TRUE(std::isnan(mended.tau(301, 0)));
  EXPECT_TRUE(std::isfinite(mended.tau(303, 0)));
  EXPECT_NE(remarks_.find("all torques drop to zero amid the motion in 3 rows, which are gaps"), std::string::npos) << remarks_;
}

TEST_F(AWrongRow, WithAWrappedAngleIsUnwrapped) {
  const double turn = 2.0 * std::acos(-1.0);
  Recording r = smooth();
  const Recording whole = r;
  for (double& q : r.q.reshaped()) q -= turn * std::floor(q / turn);  // 0 to 2 pi
  RecordingOptions options;
  options.signals.joints = {{"a", false, -2.0, 2.0}, {"b", false, -2.0, 2.0}};
  const Recording mended = read(r, options);
  EXPECT_LT((mended.q - whole.q).cwiseAbs().maxCoeff(), 1e-8) << remarks_;
  EXPECT_NE(remarks_.find("q1 (a) is wrapped"), std::string::npos) << remarks_;
  // In degrees that the options declare, and in degrees that nobody did.
  Recording degrees = r;
  degrees.q *= 360.0 / turn;
  options.signals.units = {{"q", "deg"}};
  EXPECT_LT((read(degrees, options).q - whole.q).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_EQ(remarks_.find("jump"), std::string::npos);
  const Recording undeclared = read(degrees);
  EXPECT_LT((undeclared.q.bottomRows(kMendedRows - 1) - undeclared.q.topRows(kMendedRows - 1)).cwiseAbs().maxCoeff(), 2.0);
}

TEST_F(AWrongRow, OfABurstIsRetimedSinceThePreviousBurst) {
  const Recording r = smooth();
  write_times(r, [&](int k) { return std::to_string(r.time[k - k % 8 + 7] + 1e-4 * (k % 8 - 7)); });
  const Recording mended = read_again({});
  ASSERT_EQ(mended.rows(), kMendedRows);
  EXPECT_LT((mended.time - r.time).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_NE(remarks_.find("1200 rows came in bursts"), std::string::npos) << remarks_;
  read_again(as_recorded());
  EXPECT_EQ(remarks_, "");
}

TEST_F(AWrongRow, AfterAClockStepIsTimedContinuously) {
  const Recording r = smooth();
  write_times(r, [&](int k) { return std::to_string(r.time[k] - (k >= 600 ? 0.49 : 0.0)); });
  const Recording mended = read_again({});
  EXPECT_LT((mended.time - r.time).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_NE(remarks_.find("at row 600 while the arm moves on"), std::string::npos) << remarks_;
}

// A clock that counts seconds, and from some row on milliseconds, or the other way round.
TEST_F(AWrongRow, OfAClockThatChangesItsUnitIsScaled) {
  const Recording r = smooth();
  for (const bool later : {true, false}) {
    write_times(r, [&](int k) { return std::to_string((k >= 600) == later ? 1e3 * r.time[k] : r.time[k]); });
    RecordingOptions options;
    if (!later) options.signals.units = {{"t", "ms"}};
    EXPECT_LT((read_again(options).time - r.time).cwiseAbs().maxCoeff(), 1e-5) << later;
    EXPECT_NE(remarks_.find(later ? "from row 600 on the times are in another unit: divided by 1000" : "multiplied by 1000"), std::string::npos) << remarks_;
  }
  write_times(r, [&](int k) { return std::to_string(k >= 600 ? 1e3 * r.time[k] : r.time[k]); });
  EXPECT_GT(read_again(as_recorded()).time[kMendedRows - 1], 1e4);
  EXPECT_EQ(remarks_, "");
}

TEST_F(AWrongRow, OfASecondRecordingIsRefusedWithOptionsThatSeparateIt) {
  const Recording r = smooth();
  write_times(r, [&](int k) { return std::to_string(r.time[k % 600]); });
  EXPECT_NE(error_of({}).find(":602:1: found time 0 s after 5.99 s, expected it to grow; a second recording begins at row 600: --rows 0:600"), std::string::npos)
      << error_of({});
  RecordingOptions first, second, counted;
  first.row_count = 600;
  second.first_row = 600;
  counted.rate = 100.0;
  EXPECT_EQ(read_again(first).rows(), 600);
  EXPECT_EQ(read_again(second).rows(), 600);
  EXPECT_LT((read_again(counted).time - r.time).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_NE(remarks_.find("the rows are counted at 100 Hz"), std::string::npos) << remarks_;
}

TEST_F(AWrongRow, WithTruncatedTimesIsTimedByTheRateOption) {
  const Recording r = smooth();
  for (const std::string time : {"1.75E+09", "1748433664.000000"}) {
    write_times(r, [&](int) { return time; });
    EXPECT_NE(error_of({}).find("the times have lost their digits, and --rate HZ counts the rows instead."), std::string::npos) << error_of({});
    RecordingOptions counted;
    counted.rate = 100.0;
    const Recording mended = read_again(counted);
    ASSERT_EQ(mended.rows(), kMendedRows);
    EXPECT_NEAR(mended.time[kMendedRows - 1] - mended.time[0], r.time[kMendedRows - 1], 1e-6);
  }
  // Hundredths of a second at 400 Hz.
  write_times(r, [&](int k) { return std::to_string(0.01 * std::floor(0.25 * k)); });
  const Recording spread = read_again({});
  ASSERT_EQ(spread.rows(), kMendedRows);
  EXPECT_NEAR(spread.time[401], 1.0025, 1e-6);
}

TEST_F(AWrongRow, IsNotReportedForTimesGivenAsDates) {
  const Recording r = smooth();
  for (const char* form : {"2024-02-29 23:59:%06.3f", "2024-02-29T23:59:%06.3fZ", "2024/02/29 23:59:%06.3f+01:00", "23:59:%06.3f"}) {
    write_times(r, [&](int k) {
      char date[40];
      std::snprintf(date, sizeof date, form, 30.0 + r.time[k]);
      return std::string(date);
    });
    EXPECT_LT((read_again({}).time - r.time).cwiseAbs().maxCoeff(), 1e-6) << form;
  }
  write_times(r, [](int) { return "2024-13-29 23:59:00"; });
  EXPECT_NE(error_of({}).find("expected a number of seconds or a date"), std::string::npos);
}

// Counts about a zero, shares of a range and of a torque, a register with a direction bit, a factor.
TEST_F(AWrongRow, IsNotReportedForAnotherUnit) {
  const double turn = 2.0 * std::acos(-1.0);
  const Recording r = smooth();
  Recording other = r;
  other.q = r.q * (4096.0 / turn);
  other.q.array() += 2048.0;
  RecordingOptions options;
  options.signals.joints = {{"a", false, -1.0, 3.0, 40.0}, {"b", false, -2.0, 2.0, 20.0}};
  options.signals.units = {{"q", "4096/rev@2048"}, {"tau", "%"}};
  other.tau.col(0) = r.tau.col(0) / 0.4;
  other.tau.col(1) = r.tau.col(1) / 0.2;
  Recording read_back = read(other, options);
  EXPECT_LT((read_back.q - r.q).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT((read_back.tau - r.tau).cwiseAbs().maxCoeff(), 1e-6);
  other.q.col(0) = (r.q.col(0).array() - 1.0) / 2.0 * 100.0;
  other.q.col(1) = r.q.col(1) / 2.0 * 100.0;
  other.tau.col(0) = (r.tau.col(0) * (1023.0 / 40.0)).array().round();
  other.tau.col(1) = (-r.tau.col(1) * (1023.0 / 20.0)).array().round() + 1024.0;
  options.signals.units = {{"q", "%"}, {"tau", "load"}, {"dq", "1"}};
  read_back = read(other, options);
  EXPECT_LT((read_back.q - r.q).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT((read_back.tau - r.tau).cwiseAbs().maxCoeff(), 0.03);
  options.signals.joints.clear();
  EXPECT_NE(error_of(options).find("expected a robot file that gives them"), std::string::npos) << error_of(options);
}

}  // namespace
}  // namespace veridyn
