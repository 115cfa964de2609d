#include "veridyn/recordings/recording_quality.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <random>
#include <set>

#include "support/clean_recording.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kRate = kCleanRate;
constexpr int kRows = kCleanRows;
constexpr int kJoints = kCleanJoints;

std::set<std::string> names_of(const RecordingQuality& quality) {
  std::set<std::string> names;
  for (const QualityFinding& finding : quality.findings) names.insert(name_of(finding.kind));
  return names;
}

// Exactly these findings beside the sample rate.
void expect_only(const RecordingQuality& quality, std::set<std::string> names) {
  names.insert("sample_rate");
  EXPECT_EQ(names_of(quality), names) << quality.report();
}

const QualityFinding& found(const RecordingQuality& quality, const std::string& name, std::optional<JointIndex> joint = {}) {
  for (const QualityFinding& finding : quality.findings) {
    if (name == name_of(finding.kind) && (!joint || finding.joint == joint)) return finding;
  }
  throw std::runtime_error(name + " is missing in\n" + quality.report());
}

TEST(ACleanRecording, HasNoFindingButItsRate) {
  const RecordingQuality quality = check_recording(clean_recording());
  expect_only(quality, {});
  EXPECT_NEAR(quality.rate, kRate, 1e-6);
  EXPECT_EQ(quality.rows, kRows);
  EXPECT_EQ(quality.joints, kJoints);
  EXPECT_EQ(quality.severity(), Severity::kInfo);
}

TEST(ACleanRecording, WithoutVelocitiesOrTorquesHasNoFinding) {
  Recording r = clean_recording();
  r.dq.resize(0, 0);
  expect_only(check_recording(r), {});
  r = clean_recording();
  r.tau.resize(0, 0);
  expect_only(check_recording(r), {"no_torque"});
}

// What keeps an identification from its work is said by `check`, with the way on.
TEST(ARecording, ThatIsUnusableReportsTheReason) {
  Recording r = clean_recording();
  r.tau.setConstant(1e-308);
  EXPECT_EQ(found(check_recording(r), "zero_signal").severity, Severity::kFault);
  r = clean_recording();
  r.tau.col(1).setConstant(std::nan(""));
  EXPECT_NE(found(check_recording(r), "gaps").sentence.find("(tau2) holds no number in any row"), std::string::npos);
  r = clean_recording();
  r.tau.setConstant(std::nan(""));
  EXPECT_NE(check_recording(r).find(QualityKind::kNoTorque), nullptr);
  r = rows_of(clean_recording(), 0, 200);
  EXPECT_NE(found(check_recording(r), "short_recording").sentence.find("--drop-start"), std::string::npos);
  r = clean_recording();
  r.time *= 1e3;
  const RecordingQuality quality = check_recording(r);
  EXPECT_NE(found(quality, "time_unit").sentence.find("--units t=ms mends it"), std::string::npos);
  EXPECT_EQ(quality.find(QualityKind::kRateContradiction), nullptr);
}

// A simulated recording has neither noise nor quantisation, rests at both ends, and its torque is
// smooth.
TEST(ACleanRecording, WithoutNoiseHasNoFinding) {
  Recording r = clean_recording();
  for (int k = 0; k < kRows; ++k) {
    const double s =
        std::min(1.0, std::max(0.0, (r.time[k] - 2.0) / 26.0));  // rests for 2 s before and after
    const double speed = s > 0.0 && s < 1.0 ? 30.0 * s * s * (1 - s) * (1 - s) / 26.0 : 0.0;
    const double travel = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
    for (int j = 0; j < kJoints; ++j) {
      r.q(k, j) = (1.0 + 0.3 * j) * travel;
      r.dq(k, j) = (1.0 + 0.3 * j) * speed;
      r.tau(k, j) = std::cos(r.q(k, j)) + 0.5 * r.dq(k, j);
    }
  }
  expect_only(check_recording(r), {"move_as_one"});  // one profile, in proportion
  r.dq.resize(0, 0);
  expect_only(check_recording(r), {"move_as_one"});
}

// ---- one planted fault at a time: found, with its size, and nothing else

TEST(AFault, StaleRowsAreReportedWithTheirShare) {
  Recording r = clean_recording();
  int planted = 0;
  for (int k = 10; k < kRows; k += k % 3 == 0 ? 7 : 9, ++planted) {
    for (const RecordingSignal& signal : kRecordingSignals) {
      MatrixXd& values = r.*signal.values;
      if (values.cols() > 0) values.row(k) = MatrixXd(values.row(k - 1));
    }
  }
  const RecordingQuality quality = check_recording(r);
  expect_only(quality, {"stale_rows"});
  EXPECT_NEAR(found(quality, "stale_rows").share, static_cast<double>(planted) / kRows, 1e-9);
  EXPECT_EQ(found(quality, "stale_rows").value, 1.0);
}

TEST(AFault, ASignalUpdatedAtHalfTheRateIsReportedAsStale) {
  Recording r = clean_recording();
  for (int k = 1; k < kRows; k += 2) r.tau(k, 1) = r.tau(k - 1, 1);
  const RecordingQuality quality = check_recording(r);
  expect_only(quality, {"stale_signal"});
  EXPECT_EQ(found(quality, "stale_signal").signal, "tau");
  EXPECT_EQ(found(quality, "stale_signal").joint, JointIndex{1});
  EXPECT_NEAR(found(quality, "stale_signal").share, 0.5, 0.02);
}

TEST(AFault, GapsAreReportedWithJointAndShare) {
  Recording r = clean_recording();
  for (int k = 100; k < 160; ++k) r.tau(k, 2) = NAN;
  const RecordingQuality quality = check_recording(r);
  expect_only(quality, {"gaps"});
  EXPECT_EQ(found(quality, "gaps").joint, JointIndex{2});
  EXPECT_NEAR(found(quality, "gaps").share, 60.0 / kRows, 1e-12);
  EXPECT_EQ(found(quality, "gaps").value, 60.0);
}

TEST(AFault, MissingRowsAreReportedWithTheirNumber) {
  const Recording whole = clean_recording();
  Recording r = whole;
  r.time.tail(4000).array() += 25 / kRate;
  const RecordingQuality quality = check_recording(r);
  ASSERT_TRUE(quality.find(QualityKind::kMissingRows) != nullptr) << quality.report();
  EXPECT_NEAR(found(quality, "missing_rows").value, 26 / kRate, 1e-9);
  EXPECT_NEAR(found(quality, "missing_rows").share, 25.0 / (kRows + 25), 1e-9);
  EXPECT_EQ(quality.find(QualityKind::kIrregularTime), nullptr);
}

// The second half comes at a quarter of the rate: no row is missing there.
TEST(AFault, AnotherRateInTheSecondHalfIsReported) {
  const Recording r = clean_recording();
  Recording two = rows_of(r, 0, kRows / 2);
  for (int k = kRows / 2; k < kRows; k += 4) append(two, rows_of(r, k, 1));
  const RecordingQuality quality = check_recording(two);
  EXPECT_NEAR(found(quality, "two_rates").value, kRate / 4, 1e-6);
  EXPECT_EQ(quality.find(QualityKind::kMissingRows), nullptr) << quality.report();
}

TEST(AFault, ADuplicatedColumnIsReported) {
  Recording r = clean_recording();
  r.tau.col(2) = r.tau.col(0);
  EXPECT_EQ(found(check_recording(r), "same_column").joint, JointIndex{2});
  EXPECT_EQ(found(check_recording(r), "same_column").severity, Severity::kFault);
}

TEST(AFault, ATorqueColumnThatHoldsAVelocityIsNamed) {
  Recording r = clean_recording();
  r.tau.col(1) = r.dq.col(1);
  EXPECT_NE(found(check_recording(r), "same_column").sentence.find("dq2 and tau2 hold the same numbers"), std::string::npos);
}

TEST(AFault, SwappedVelocitiesAreReportedWithBothJoints) {
  Recording r = clean_recording();
  r.dq.col(0).swap(r.dq.col(2));
  const RecordingQuality quality = check_recording(r);
  EXPECT_NE(found(quality, "velocity_unrelated", {{0}}).sentence.find("that of joint 3 is; --map dq1=dq3 mends it"), std::string::npos);
  EXPECT_NE(found(quality, "velocity_unrelated", {{2}}).sentence.find("that of joint 1 is; --map dq3=dq1 mends it"), std::string::npos);
}

// Values are missing to either side of each extreme.
TEST(AFault, MissingValuesAroundExtremesAreNotReportedAsSaturation) {
  const Recording clean = clean_recording();
  Recording r = clean;
  for (int j = 0; j < r.joints(); ++j) {
    const double largest = clean.tau.col(j).cwiseAbs().maxCoeff();
    for (int k = 6; k + 6 < r.rows(); ++k) {
      const auto is_near = [&](int row) { return std::abs(clean.tau(row, j)) > 0.92 * largest; };
      if (is_near(k) && !is_near(k - 1)) r.tau.col(j).segment(k - 6, 6).setConstant(std::nan(""));
      if (is_near(k) && !is_near(k + 1)) r.tau.col(j).segment(k + 1, 6).setConstant(std::nan(""));
    }
  }
  EXPECT_EQ(check_recording(clean).find(QualityKind::kSaturation), nullptr);
  EXPECT_EQ(check_recording(r).find(QualityKind::kSaturation), nullptr) << check_recording(r).report();
}

// A register of 16 bits and the like: what leaves its range comes in at the other end.
TEST(AFault, AnOverflowingTorqueIsNotReportedAsSaturated) {
  Recording r = clean_recording();
  const double end = 0.6 * r.tau.col(1).cwiseAbs().maxCoeff();
  for (double& x : r.tau.col(1)) x -= 2.0 * end * std::round(x / (2.0 * end));
  const RecordingQuality quality = check_recording(r);
  EXPECT_EQ(found(quality, "overflow", {{1}}).severity, Severity::kFault) << quality.report();
  EXPECT_EQ(quality.find(QualityKind::kSaturation), nullptr) << quality.report();
}

// Forty rows in a second are lost now and then, and the times are counted on.
TEST(AFault, LostRowsAreReportedAsJumpsAndNotAsASecondRecording) {
  const Recording clean = clean_recording();
  Recording r = clean;
  int kept = 0;
  for (int k = 0; k < clean.rows(); ++k) {
    if (k % 600 >= 560) continue;
    for (MatrixXd Recording::*signal : {&Recording::q, &Recording::dq, &Recording::tau}) (r.*signal).row(kept) = (clean.*signal).row(k);
    ++kept;
  }
  r = rows_of(r, 0, kept);
  const RecordingQuality quality = check_recording(r);
  const QualityFinding* jumps = quality.find(QualityKind::kJumps, JointIndex{0});
  ASSERT_NE(jumps, nullptr) << quality.report();
  EXPECT_NE(jumps->sentence.find("rows were lost there"), std::string::npos) << jumps->sentence;
}

// Dry friction of a joint that turns round 0.12 s after the start.
TEST(AFault, AnEarlyFrictionReversalIsNotReportedAsATransient) {
  const Recording clean = clean_recording();
  for (int j = 0; j < kJoints; ++j) {
    int turn = 400;
    while (clean.dq(turn - 1, j) * clean.dq(turn, j) > 0.0) ++turn;
    Recording r = rows_of(clean, turn - 24, clean.rows() - turn + 24);
    const double way = r.q(24, j) > r.q(0, j) ? 1.0 : -1.0;
    r.tau.col(j).head(24).array() += way;
    EXPECT_EQ(check_recording(r).find(QualityKind::kStartUpTransient), nullptr) << check_recording(r).report();
  }
}

// Dry friction that turns round where the recorded position does not: a set point that leads, or another coordinate.
TEST(AFault, OneStepOfTheTorqueAtTheStartDoesNotRing) {
  for (int row = 10; row < 200; row += 7) {
    Recording r = clean_recording();
    r.tau.col(1).head(row).array() += 2.0;
    EXPECT_EQ(check_recording(r).find(QualityKind::kStartUpTransient), nullptr) << row << "\n" << check_recording(r).report();
  }
}

// Two wrong values near the start.
TEST(AFault, SingleWrongTorquesAreNotReportedAsATransient) {
  Recording r = clean_recording();
  for (const int row : {5, 31}) r.tau(row, 0) += 20.0 * r.tau.col(0).cwiseAbs().maxCoeff();
  EXPECT_EQ(check_recording(r).find(QualityKind::kStartUpTransient), nullptr);
}

// A torque that is refreshed every tenth row holds its extremes as it holds all values.
TEST(AFault, ATorqueHeldForTenRowsIsNotReportedAsSaturated) {
  Recording r = clean_recording();
  for (int k = 0; k < kRows; ++k) r.tau.row(k) = r.tau.row(k - k % 10).eval();  // one new value in ten rows
  const RecordingQuality quality = check_recording(r);
  EXPECT_NEAR(found(quality, "stale_signal").share, 0.9, 1e-3);
  EXPECT_EQ(quality.find(QualityKind::kSaturation), nullptr) << quality.report();
  EXPECT_TRUE(quality.saturated.empty());
}

TEST(AFault, TorquesThatAreNeverNegativeAreReported) {
  Recording r = clean_recording();
  EXPECT_EQ(check_recording(r).find(QualityKind::kNoSign), nullptr);
  r.tau = r.tau.cwiseAbs().eval();
  EXPECT_EQ(found(check_recording(r), "no_sign").severity, Severity::kFault);
}

// Commanded positions are ahead of measured velocities, and no clock is off.
TEST(AFault, PositionsAheadOfVelocitiesAreReportedAsADelay) {
  Recording r = clean_recording();
  const int ahead = static_cast<int>(0.08 * kRate);
  r.q.topRows(kRows - ahead) = r.q.bottomRows(kRows - ahead).eval();
  r = rows_of(r, 0, kRows - ahead);
  const RecordingQuality quality = check_recording(r);
  EXPECT_NE(quality.find(QualityKind::kVelocityDelay), nullptr) << quality.report();
  EXPECT_EQ(quality.find(QualityKind::kRateContradiction), nullptr) << quality.report();
}

TEST(AFault, RevolutionsPerMinuteAreNotReportedAsDegrees) {
  Recording r = clean_recording();
  r.dq *= 60.0;
  EXPECT_NE(found(check_recording(r), "rate_contradiction").sentence.find("--units q=rev,dq=rpm"), std::string::npos);
}

TEST(AFault, IrregularTimeIsReportedWithTheMeanRate) {
  Recording r = clean_recording();
  Recording kept = r;
  int count = 0;
  for (int k = 0; k < kRows; k += 4 + (k / 4) % 2, ++count) {  // 20 and 25 ms
    kept.time[count] = r.time[k];
    kept.q.row(count) = r.q.row(k);
    kept.dq.row(count) = r.dq.row(k);
    kept.tau.row(count) = r.tau.row(k);
  }
  kept = rows_of(kept, 0, count);
  const RecordingQuality quality = check_recording(kept);
  expect_only(quality, {"irregular_time"});
  EXPECT_NEAR(found(quality, "irregular_time").value, (count - 1) / kept.time[count - 1], 1e-6);
}

TEST(AFault, AbsurdNumbersAreReportedAndTreatedAsGaps) {
  Recording r = clean_recording();
  r.q(1000, 0) = 1e305;
  r.tau(2000, 1) = -INFINITY;
  const RecordingQuality quality = check_recording(r);
  expect_only(quality, {"absurd_numbers", "gaps"});
  EXPECT_EQ(found(quality, "absurd_numbers").value, 2.0);
  EXPECT_EQ(quality.severity(), Severity::kFault);
}

TEST(AFault, JumpsAreReportedWithSizeAndJoint) {
  const std::function<void(Recording*)> without_velocities[] = {
      [](Recording*) {}, [](Recording* r) { r->dq.resize(0, 0); }};
  for (const auto& change : without_velocities) {
    Recording r = clean_recording();
    change(&r);
    r.q.col(1).tail(2500).array() += 0.2;  // slips a tooth
    r.q(1234, 2) += 0.3;                   // one wrong value
    const RecordingQuality quality = check_recording(r);
    expect_only(quality, {"jumps"});
    EXPECT_NEAR(found(quality, "jumps", {{1}}).value, 0.2, 0.03);
    EXPECT_NEAR(std::abs(found(quality, "jumps", {{2}}).value), 0.3, 0.03);
    EXPECT_EQ(quality.find(QualityKind::kJumps, JointIndex{0}), nullptr);
  }
}

TEST(AFault, AClippedTorqueIsReportedAsSaturated) {
  Recording r = clean_recording();
  const double limit = 0.6 * r.tau.col(0).maxCoeff();
  r.tau.col(0) = r.tau.col(0).cwiseMin(limit);
  const double share = static_cast<double>((r.tau.col(0).array() == limit).count()) / kRows;
  const RecordingQuality quality = check_recording(r);
  expect_only(quality, {"saturation"});
  EXPECT_NEAR(found(quality, "saturation", {{0}}).value, limit, 0.01 * limit);
  EXPECT_NEAR(found(quality, "saturation", {{0}}).share, share, 0.1 * share);
}

// Into a limit that a slow torque reaches there is no step; two of one size give it away.
TEST(AFault, ATorqueClippedAtSymmetricLimitsIsReported) {
  Recording r = clean_recording();
  const VectorXd wave = (r.time.array() * 2.0).sin();
  r.tau.col(0) = wave.cwiseMin(0.8).cwiseMax(-0.8);
  const auto rows = static_cast<double>((r.tau.col(0).array() == 0.8).count());
  const RecordingQuality quality = check_recording(r);
  expect_only(quality, {"saturation"});
  EXPECT_NEAR(found(quality, "saturation", {{0}}).share, rows / kRows, 0.05 * rows / kRows);
  double seconds = 0.0;
  for (const SaturatedInterval& part : quality.saturated) {
    EXPECT_EQ(part.joint, JointIndex{0});
    seconds += part.to - part.from;
  }
  const double share = (r.tau.col(0).cwiseAbs().array() == 0.8).count() / static_cast<double>(kRows);
  EXPECT_NEAR(seconds, share * quality.duration, 0.05 * share * quality.duration);
  for (const double step : {1e-9, 0.01, 0.1}) {
    r.tau.col(0) = ((wave / step).array().round() * step).matrix();
    EXPECT_TRUE(check_recording(r).saturated.empty()) << step;
  }
}

// Dry friction on which a slow torque rides stays within 8 % of its extreme while the joint speeds up; a limit with noise does, too.
TEST(AFault, FrictionOnWhichATorqueRidesIsNotSaturated) {
  for (const double share : {0.0, 0.05}) {
    Recording r = clean_recording();
    for (int k = 0; k < kRows; ++k) {
      const double wave = std::sin(1.3 * r.time[k]), noise = 0.01 * (k * 7919 % 101 - 50) / 50.0;
      r.tau(k, 0) = std::clamp(10.0 * wave, -2.0, 2.0) * (1.0 + share * std::abs(wave)) + noise;
    }
    EXPECT_EQ(check_recording(r).find(QualityKind::kSaturation) == nullptr, share > 0.0) << check_recording(r).report();
  }
}

TEST(AFault, ATorqueThatStaysAtZeroIsNotReportedAsSaturated) {
  Recording r = clean_recording();
  r.tau.col(0) = (r.tau.col(0).array() - 0.6 * r.tau.col(0).maxCoeff()).cwiseMin(0.0);
  const RecordingQuality quality = check_recording(r);
  const QualityFinding& zero = found(quality, "saturation", {{0}});
  EXPECT_EQ(zero.value, 0.0);
  EXPECT_NE(zero.sentence.find("a dead zone, or a channel of one sign"), std::string::npos) << zero.sentence;
}

// Steps of a thirtieth of the range: the largest value is one of few, and no limit.
TEST(AFault, ACoarselyQuantisedTorqueIsNotReportedAsSaturated) {
  Recording r = clean_recording();
  for (int j = 0; j < kJoints; ++j) {
    const double step = (r.tau.col(j).maxCoeff() - r.tau.col(j).minCoeff()) / 32.0;
    for (double& x : r.tau.col(j)) x = step * std::round(x / step);
  }
  expect_only(check_recording(r), {});
}

// Whole newton metres of a small torque: its extreme lasts as long as a step, and is no limit.
TEST(AFault, ATorqueInStepsAsWideAsItsCrestIsNotReportedAsSaturated) {
  for (unsigned seed = 1; seed < 10; ++seed) {
    Recording r = clean_recording(seed);
    for (int j = 0; j < kJoints; ++j) r.tau.col(j) = (3.4 / r.tau.col(j).cwiseAbs().maxCoeff() * r.tau.col(j)).array().round().matrix();
    const RecordingQuality quality = check_recording(r);
    EXPECT_EQ(quality.find(QualityKind::kSaturation), nullptr) << quality.report();
    EXPECT_NE(quality.find(QualityKind::kTorqueQuantised, JointIndex{0}), nullptr) << quality.report();
  }
}

TEST(AFault, RingingAtTheStartIsReportedAsATransient) {
  Recording r = clean_recording();
  for (int k = 0; r.time[k] < 0.6; ++k) r.tau(k, 1) += 3.0 * std::sin(60.0 * r.time[k]);
  const RecordingQuality quality = check_recording(r);
  expect_only(quality, {"start_up_transient"});
  EXPECT_NEAR(found(quality, "start_up_transient").value, 0.6, 0.11);
  EXPECT_EQ(found(quality, "start_up_transient").joint, JointIndex{1});
}

TEST(AFault, AWrongClockIsReportedWithItsFactor) {
  for (const double factor : {0.5, 0.93, 2.0}) {
    Recording r = clean_recording();
    r.time *= factor;  // dq = factor * dq/dt
    const RecordingQuality quality = check_recording(r);
    EXPECT_NEAR(found(quality, "rate_contradiction").value, factor, 0.005 * factor)
        << quality.report();
    EXPECT_FALSE(found(quality, "rate_contradiction").joint);
    EXPECT_EQ(quality.find(QualityKind::kVelocityScale), nullptr);
    EXPECT_EQ(quality.severity(), Severity::kFault);
  }
}

// No clock makes a velocity of another signal.
TEST(AFault, VelocitiesOfOtherSignalsAreNotReportedAsTheClock) {
  Recording r = clean_recording();
  r.dq *= 0.5;
  r.dq.col(1) = 1.7 * r.q.col(1);
  const RecordingQuality quality = check_recording(r);
  EXPECT_NE(quality.find(QualityKind::kVelocityUnrelated, JointIndex{1}), nullptr);
  EXPECT_EQ(quality.find(QualityKind::kRateContradiction), nullptr) << quality.report();
}

TEST(AFault, AVelocityFactorOnOneJointIsNotReportedAsTheClock) {
  Recording r = clean_recording();
  r.dq.col(2) *= 1.12;
  const RecordingQuality quality = check_recording(r);
  expect_only(quality, {"velocity_scale"});
  EXPECT_NEAR(found(quality, "velocity_scale", {{2}}).value, 1.12, 0.005);
}

TEST(AFault, AReversedVelocitySignIsReportedWithItsJoint) {
  Recording r = clean_recording();
  r.dq.col(1) *= -1.0;
  const RecordingQuality quality = check_recording(r);
  expect_only(quality, {"velocity_sign"});
  EXPECT_EQ(found(quality, "velocity_sign").joint, JointIndex{1});
}

TEST(AFault, AVelocityColumnHoldingAnotherSignalIsReported) {
  Recording r = clean_recording();
  r.dq.col(1) = 1.7 * r.q.col(1);
  const RecordingQuality quality = check_recording(r);
  EXPECT_EQ(found(quality, "velocity_unrelated", {{1}}).severity, Severity::kFault);
  EXPECT_EQ(quality.find(QualityKind::kVelocityUnrelated, JointIndex{0}), nullptr);
}

TEST(AFault, DegreesAreRecognised) {
  Recording r = clean_recording();
  r.dq *= 180.0 / M_PI;
  expect_only(check_recording(r), {"degrees"});
  r = clean_recording();
  r.q *= 180.0 / M_PI;
  EXPECT_TRUE(check_recording(r).find(QualityKind::kDegrees, JointIndex{0}) != nullptr);
  r = clean_recording();
  r.q.array() += 1.5;
  r.q *= 180.0 / M_PI;
  r.dq *= 180.0 / M_PI;
  const RecordingQuality both = check_recording(r);
  expect_only(both, {"degrees"});
  EXPECT_GT(found(both, "degrees", {{0}}).share, 0.5);
}

TEST(AFault, CoarseVelocityStepsAreReportedWithTheirSize) {
  Recording r = clean_recording();
  const double step = 0.3;
  for (int k = 0; k < kRows; ++k) r.dq(k, 0) = step * std::round(r.dq(k, 0) / step);
  const RecordingQuality quality = check_recording(r);
  ASSERT_TRUE(quality.find(QualityKind::kVelocityQuantised, JointIndex{0}) != nullptr) << quality.report();
  EXPECT_NEAR(found(quality, "velocity_quantised").value, step, 1e-9);
  EXPECT_EQ(quality.find(QualityKind::kVelocityQuantised, JointIndex{1}), nullptr);
}

// Eight values of a torque; 32 are none too few.
TEST(AFault, CoarseTorqueStepsAreReportedWithTheirSize) {
  for (const double levels : {8.0, 32.0}) {
    Recording r = clean_recording();
    const double step = (r.tau.col(1).maxCoeff() - r.tau.col(1).minCoeff()) / levels;
    const VectorXd fine = r.tau.col(1);
    for (double& v : r.tau.col(1)) v = step * std::round(v / step);
    const RecordingQuality quality = check_recording(r);
    EXPECT_EQ(quality.find(QualityKind::kTorqueQuantised, JointIndex{0}), nullptr) << quality.report();
    ASSERT_EQ(quality.find(QualityKind::kTorqueQuantised, JointIndex{1}) != nullptr, levels < 10.0) << quality.report();
    if (levels > 10.0) continue;
    const QualityFinding& steps = found(quality, "torque_quantised", {{1}});
    EXPECT_NEAR(steps.value, step, 1e-9);
    const double error = 100.0 * (r.tau.col(1) - fine).norm() / r.tau.col(1).norm();
    EXPECT_NEAR(std::stod(steps.sentence.substr(steps.sentence.find("error of ") + 9)), error, 0.1 * error) << steps.sentence;
  }
}

// White noise of 0.03 rad/s, where 1e-5 rad of noise in the position make 1.4e-3 rad/s.
TEST(AFault, AVelocityNoisierThanItsPositionIsReported) {
  Recording r = clean_recording();
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int k = 0; k < kRows; ++k) r.dq(k, 1) += 0.03 * normal(random);
  const RecordingQuality quality = check_recording(r);
  expect_only(quality, {"velocity_noise"});
  EXPECT_NEAR(found(quality, "velocity_noise", {{1}}).value, 0.03, 0.002);
  EXPECT_EQ(quality.find(QualityKind::kVelocityNoise, JointIndex{0}), nullptr);
}

TEST(AFault, ALateVelocityIsMeasuredToATenthOfASample) {
  for (const double delay : {2.0, 2.4, 7.0, -3.3}) {
    Recording r = clean_recording();
    const MatrixXd dq = r.dq;
    for (int k = 10; k < kRows - 10; ++k) {
      const int before = static_cast<int>(std::floor(k - delay));
      const double share = k - delay - before;
      r.dq(k, 1) = (1.0 - share) * dq(before, 1) + share * dq(before + 1, 1);
    }
    const RecordingQuality quality = check_recording(r);
    expect_only(quality, {"velocity_delay"});
    EXPECT_NEAR(found(quality, "velocity_delay", {{1}}).value, delay / kRate, 0.1 / kRate);
  }
}

TEST(AFault, AJointAtRestIsReported) {
  Recording r = clean_recording();
  r.q.col(2) *= 1e-4;
  r.dq.col(2) *= 1e-4;
  const RecordingQuality quality = check_recording(r);
  expect_only(quality, {"joint_at_rest"});
  EXPECT_EQ(found(quality, "joint_at_rest").joint, JointIndex{2});
  r.q *= 1e-4;
  r.dq *= 1e-4;
  expect_only(check_recording(r), {"no_motion"});
}

TEST(AFault, ZeroSignalsAreReported) {
  Recording r = clean_recording();
  r.tau.setZero();
  RecordingQuality quality = check_recording(r);
  expect_only(quality, {"zero_signal"});
  EXPECT_EQ(found(quality, "zero_signal").signal, "tau");
  EXPECT_FALSE(found(quality, "zero_signal").joint);
  r = clean_recording();
  r.tau.col(1).setConstant(0.25);
  quality = check_recording(r);
  EXPECT_EQ(found(quality, "constant_signal").joint, JointIndex{1});

  r.q.setZero();
  r.dq.setZero();
  r.tau.setZero();
  quality = check_recording(r);
  EXPECT_EQ(names_of(quality), (std::set<std::string>{"sample_rate", "zero_signal", "no_motion"}));
}

// A column of zeros beside a position that moves was not recorded. The noise of a resting joint, held at one
// pose after the other, and poses a second apart are no motion.
TEST(AFault, ZeroVelocitiesDuringAMotionAreReported) {
  Recording r = clean_recording();
  r.dq.col(1).setZero();
  const RecordingQuality quality = check_recording(r);
  EXPECT_EQ(found(quality, "velocity_scale", {{1}}).value, 0.0);
  EXPECT_EQ(found(quality, "velocity_scale", {{1}}).severity, Severity::kFault);
  EXPECT_EQ(quality.find(QualityKind::kVelocityScale, JointIndex{0}), nullptr);
  r.time *= kRate;
  EXPECT_EQ(check_recording(r).find(QualityKind::kVelocityScale, JointIndex{1}), nullptr);

  Recording poses = clean_recording();
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 1e-3);
  for (int k = 0; k < poses.rows(); ++k) {
    for (int j = 0; j < poses.joints(); ++j) poses.q(k, j) = 0.2 * (k / 200) + noise(random);
  }
  poses.dq.setZero();
  EXPECT_EQ(check_recording(poses).find(QualityKind::kVelocityScale, JointIndex{0}), nullptr);
}

TEST(AFault, ARepeatingMotionIsReportedWithItsPeriod) {
  Recording r = clean_recording();
  const int period = 1296;
  for (int k = period; k < kRows; ++k) r.q.row(k) = MatrixXd(r.q.row(k - period));
  const RecordingQuality quality = check_recording(r);
  EXPECT_NEAR(found(quality, "period").value, period / kRate, 0.2 / kRate);
  EXPECT_NEAR(quality.period.seconds, period / kRate, 0.2 / kRate);
}

TEST(AFault, ARecordingOfFewRowsIsReportedAsTooShort) {
  const RecordingQuality quality = check_recording(rows_of(clean_recording(), 0, 20));
  EXPECT_EQ(names_of(quality), std::set<std::string>{"short_recording"});
  EXPECT_EQ(check_recording(rows_of(clean_recording(), 0, 1)).rows, 1);
  EXPECT_THROW(check_recording(Recording()), InvalidInput);
}

// Rows beyond the head are counted piece by piece; a fault at the boundary of two pieces is counted as well.
TEST(ALongRecording, IsCheckedToItsEndAcrossPieceBoundaries) {
  const Recording part = clean_recording();
  const int copies = 50;
  Recording r;
  r.source = "long";
  r.time = VectorXd::LinSpaced(copies * kRows, 0.0, (copies * kRows - 1) / kRate);
  r.q = part.q.replicate(copies, 1);
  r.dq = part.dq.replicate(copies, 1);
  r.tau = part.tau.replicate(copies, 1);
  const int seams = static_cast<int>(check_recording(r).findings.size());
  int planted = 0;
  for (int k = 100; k < r.rows(); k += 1000, ++planted) {
    r.q.row(k) = MatrixXd(r.q.row(k - 1));
    r.dq.row(k) = MatrixXd(r.dq.row(k - 1));
    r.tau.row(k) = MatrixXd(r.tau.row(k - 1));
  }
  const int last = 199999 - 199999 % 1000 + 1000;  // the first row of the second piece is 200,000
  r.q.row(last) = MatrixXd(r.q.row(last - 1));
  r.dq.row(last) = MatrixXd(r.dq.row(last - 1));
  r.tau.row(last) = MatrixXd(r.tau.row(last - 1));
  const RecordingQuality quality = check_recording(r);
  EXPECT_EQ(quality.rows, copies * kRows);
  EXPECT_EQ(static_cast<int>(quality.findings.size()), seams + 1);
  EXPECT_NEAR(found(quality, "stale_rows").share, static_cast<double>(planted + 1) / r.rows(),
              1e-12);
}

// A step at any row around the end of the head (200,000 rows) is detected exactly once.
TEST(ALongRecording, JumpsAtAPieceBoundaryAreDetectedOnce) {
  Recording smooth;
  smooth.source = "long";
  smooth.time = VectorXd::LinSpaced(200100, 0.0, 200099 / kRate);
  smooth.q = (0.1 * smooth.time.array()).sin().matrix();
  for (int row = 199994; row <= 200006; ++row) {
    Recording r = smooth;
    r.q.col(0).tail(r.rows() - row).array() += 0.5;
    const RecordingQuality quality = check_recording(r);
    const QualityFinding& jump = found(quality, "jumps", {{0}});
    EXPECT_NEAR(jump.value, 0.5, 0.01);
    EXPECT_NE(jump.sentence.find("jumps 1 time,"), std::string::npos)
        << row << ": " << jump.sentence;
  }
}

TEST(AReport, HasOneLinePerFinding) {
  const RecordingQuality quality = check_recording(clean_recording());
  const std::string report = quality.report();
  EXPECT_EQ(static_cast<std::size_t>(std::count(report.begin(), report.end(), '\n')),
            1 + quality.findings.size());
}

// ---- real recordings

class ARealRecording : public testing::Test {
 protected:
  void SetUp() override {
    const char* given = std::getenv("VERIDYN_REAL_DATA");
    folder_ = given != nullptr ? given : VERIDYN_SOURCE_DIR "/../shared/data";
    if (!std::filesystem::exists(folder_)) GTEST_SKIP() << "no real recordings in " << folder_;
  }
  RecordingQuality check(const std::string& name) const {
    return check_recording(folder_ + "/" + name + ".csv");
  }
  std::string folder_;
};

TEST_F(ARealRecording, OfTheThesisRepeatsAtTheFrequencyOfItsTable) {
  const double frequency[] = {0.10, 0.13, 0.16, 0.20, 0.14, 0.12};
  for (int file = 1; file <= 6; ++file) {
    const RecordingQuality quality = check(text("psm1-thesis/fourier-", file));
    EXPECT_NEAR(quality.period.seconds * frequency[file - 1], 1.0, 2e-5) << quality.report();
    EXPECT_NEAR(quality.rate, 200.0, 1e-6);
    EXPECT_TRUE(quality.find(QualityKind::kStartUpTransient) != nullptr);
    EXPECT_EQ(quality.find(QualityKind::kStaleRows) != nullptr, file >= 5);
    for (const QualityKind absent : {QualityKind::kJumps, QualityKind::kGaps, QualityKind::kRateContradiction,
                                     QualityKind::kVelocityScale, QualityKind::kVelocityDelay, QualityKind::kDegrees}) {
      EXPECT_EQ(quality.find(absent), nullptr) << quality.report();
    }
  }
  EXPECT_NEAR(found(check("psm1-thesis/fourier-1"), "saturation", {{1}}).value, 3.1, 0.1);
  EXPECT_NEAR(found(check("psm1-thesis/fourier-5"), "stale_rows").share, 0.123, 0.001);
}

TEST_F(ARealRecording, OfForceRampsHasJumpsOfTheInsertion) {
  const RecordingQuality quality = check("psm1-thesis/force-ramp");
  EXPECT_NEAR(found(quality, "jumps", {{2}}).value, -0.206, 0.001);
  EXPECT_NEAR(quality.rate, 100.0, 1e-6);
  EXPECT_EQ(check("psm1-thesis/constant-velocity-positive").severity(), Severity::kInfo);
}

TEST_F(ARealRecording, OfTheWristRepeatsEvery1296Rows) {
  for (const char* name :
       {"one", "two", "one-no-weight", "one-105g-parallel", "one-205g-parallel"}) {
    const RecordingQuality quality = check(text("psm-wrist/", name));
    EXPECT_NEAR(quality.period.seconds, 1296 / 200.0, 0.2 / 200.0);
    EXPECT_EQ(quality.severity(), Severity::kInfo) << quality.report();
  }
}

TEST_F(ARealRecording, OfTheMasterHasVelocitiesOfJoints5To7TooLarge) {
  for (const char* name : {"mtm/one", "mtm/two"}) {
    const RecordingQuality quality = check(name);
    EXPECT_NEAR(quality.period.seconds, 2333 / 200.0, 0.2 / 200.0);
    for (int joint = 1; joint <= 4; ++joint)
      EXPECT_EQ(quality.find(QualityKind::kVelocityScale, JointIndex{joint - 1}), nullptr);
    for (int joint = 5; joint <= 7; ++joint) {
      EXPECT_GT(found(quality, "velocity_scale", JointIndex{joint - 1}).value, 1.025);
      EXPECT_LT(found(quality, "velocity_scale", JointIndex{joint - 1}).value, 1.19);
      EXPECT_TRUE(quality.find(QualityKind::kVelocityQuantised, JointIndex{joint - 1}) != nullptr);
    }
    EXPECT_GT(found(quality, "stale_rows").share, 0.1);
  }
}

TEST_F(ARealRecording, OfTheUr10eHasIrregularTimeAt94Hz) {
  for (const char* name :
       {"free-12harm30s-2020-02-10", "free-14harm50s-2020-02-19", "free-8harm20s-2020-02-05",
        "free-point-to-point-2020-01-17", "load-2805g-14harm50s-2020-02-19",
        "one-joint-2-2020-01-22", "push-pose-1", "static-pose-1-2020-01-17", "repeat-a-2019-10-01",
        "repeat-b-2019-10-01"}) {
    const RecordingQuality quality = check(text("ur10e/", name));
    EXPECT_NEAR(found(quality, "irregular_time").value, 94.2, 1.2);
    for (const QualityFinding& finding : quality.findings) {
      EXPECT_TRUE(finding.severity == Severity::kInfo || finding.kind == QualityKind::kIrregularTime)
          << quality.report();
    }
  }
}

TEST_F(ARealRecording, ThatIsBrokenIsReportedAsFaulty) {
  const RecordingQuality quality = check("ur10e/broken-file-2019-09-27");
  EXPECT_EQ(found(quality, "absurd_numbers").severity, Severity::kFault);
  EXPECT_EQ(quality.rows, 1138);  // of 1139: one row of zeros alone is left out
}

}  // namespace
}  // namespace veridyn
