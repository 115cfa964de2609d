#include "veridyn/identification/compressed_recording.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "identification/synthetic_recording.hpp"
#include "support/near.hpp"
#include "identification/base_solution.hpp"
#include "math/zero_phase_filter.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

Model robot(const std::string& name) {
  return read_model(VERIDYN_SOURCE_DIR "/data/robots/" + name + ".yaml");
}

MotionShape lasting(double seconds, double period = 0.0) {
  MotionShape shape;
  shape.duration = seconds;
  shape.period = period;
  return shape;
}

Recording noisy(const Model& arm, const MotionShape& shape, double share, unsigned seed) {
  Recording r = synthetic_recording(arm, shape);
  r.tau += noise_like(r.tau, share, seed);
  return r;
}

PreprocessingOptions without_edges() {
  PreprocessingOptions o;
  o.drop_start = o.drop_end = 0.0;
  return o;
}

MatrixXd low_passed(MatrixXd columns, const PreprocessingOptions& o, double rate) {
  ZeroPhaseFilter(o.cutoff, o.order, rate).apply(columns);
  return columns;
}

// ---- factors
// -------------------------------------------------------------------------------------------------------

// The factors hold the sum of squares of all rows for any parameters, and nothing of the samples.
TEST(ACompressedRecording, HoldsTheSumOfSquaresOfItsRows) {
  const Model arm = robot("scara");
  const PreprocessingOptions options;
  const Recording recording = noisy(arm, lasting(45.0), 0.2, 1);
  const CompressedRecording c = compress(arm, recording, options);
  const RegressorColumns columns(arm, options);
  const std::vector<std::string> names = parameter_names(columns.parameters());
  Random random(2);
  const VectorXd x =
      true_parameters(arm) + 0.1 * random.vector(static_cast<int>(names.size()), -1, 1);
  VectorXd direct = VectorXd::Zero(4);
  double rows = 0.0;
  for_each_segment(arm, recording, options, [&](const Segment& s) {
    const std::vector<JointRows> all = columns.rows(s);
    for (size_t i = 0; i < 4; ++i) {
      VectorXd mine(all[i].A.cols());
      for (Eigen::Index p = 0; p < mine.size(); ++p)
        mine[p] = x[all[i].parameters[p]];
      direct[static_cast<Eigen::Index>(i)] += (all[i].A * mine - all[i].b).squaredNorm();
      rows += static_cast<double>(all[i].b.size());
    }
  });
  EXPECT_EQ(c.rows, rows);
  for (Eigen::Index i = 0; i < 4; ++i) {
    const SquareRootInformation total = weighted_total(joint_totals({c}), VectorXd::Unit(4, i), names);
    EXPECT_NEAR(total.residual2(x), direct[i], 1e-10 * direct[i]);
  }
}

// At the cut-off of 5 Hz one sample in ten is kept of 200 Hz; 1.2 s and 0.5 s are dropped.
TEST(ACompressedRecording, CountsTheRowsAfterDecimationAndDroppedEnds) {
  const Model arm = robot("scara");
  const CompressedRecording c = compress(arm, synthetic_recording(arm, lasting(20.0)), {});
  EXPECT_NEAR(c.rows, 4 * (20.0 - 1.7) * 20.0, 4 * 2.0);
  EXPECT_EQ(c.facts.samples, 4000);
}

TEST(ACompressedRecording, HasEightToSixteenBlocksForAnyLength) {
  const Model arm = robot("planar-2r");
  for (const double seconds : {12.0, 17.5, 18.0, 40.0, 150.0}) {
    const CompressedRecording c = compress(arm, synthetic_recording(arm, lasting(seconds)), {});
    EXPECT_FALSE(c.period.found());
    EXPECT_GE(c.blocks.size(), 8U) << seconds << " s";
    EXPECT_LE(c.blocks.size(), 16U) << seconds << " s";
    double most = 0.0;
    double all = 0.0;
    for (const auto& block : c.blocks) {
      ASSERT_EQ(block.size(), 2U);
      most = std::max(most, block[0].rows());
      all += block[0].rows();
    }
    EXPECT_LT(most, 0.2 * all) << "equal segments";
  }
}

// Repeats of a phase fall into one block, so that each of the eight holds every repeat.
TEST(ACompressedRecording, SplitsARepeatingMotionIntoEightPhases) {
  const Model arm = robot("planar-2r");
  const CompressedRecording c =
      compress(arm, synthetic_recording(arm, lasting(40.0, 8.0)), without_edges());
  EXPECT_NEAR(c.period.seconds, 8.0, 0.01);
  ASSERT_EQ(c.blocks.size(), 8U);
  for (const auto& block : c.blocks) EXPECT_NEAR(block[0].rows(), 100.0, 5.0);
}

TEST(ACompressedRecording, HasNoColumnsOfFixedParameters) {
  ModelDescription d = robot("planar-2r").description();
  d.frames[1].body->fixed = true;
  const Model arm{d};
  const CompressedRecording c = compress(arm, synthetic_recording(arm, lasting(12.0)), {});
  for (const SquareRootInformation& factor : c.blocks.front()) {
    for (const std::string& name : factor.columns())
      EXPECT_EQ(name.find("_fore"), std::string::npos) << name;
  }
}

// Rows of slow joints are left out of the factors of that joint alone.
TEST(ACompressedRecording, ExcludesSlowRows) {
  const Model arm = robot("planar-2r");
  const Recording r = synthetic_recording(arm, lasting(20.0));
  PreprocessingOptions options = without_edges();
  options.min_speed = 0.4;
  const CompressedRecording c = compress(arm, r, options);
  for (int i = 0; i < 2; ++i) {
    double rows = 0.0;
    for (const auto& block : c.blocks) rows += block[i].rows();
    long fast = 0;
    for (Eigen::Index k = 0; k < r.rows(); k += 10) fast += std::abs(r.dq(k, i)) >= 0.4 ? 1 : 0;
    EXPECT_NEAR(rows, static_cast<double>(fast), 2.0) << "joint " << i;
    EXPECT_LT(rows, 0.95 * 400.0);
  }
}

// ---- facts
// ---------------------------------------------------------------------------------------------------------

TEST(ACompressedRecording, HasTheRangesOfTorqueSpeedAndPosition) {
  const Model arm = robot("scara");
  const PreprocessingOptions options = without_edges();
  const Recording r = synthetic_recording(arm, lasting(12.0));
  const MatrixXd tau = low_passed(r.tau, options, 200.0);
  const CompressedRecording c = compress(arm, r, options);
  for (int i = 0; i < 4; ++i) {
    const TorqueFacts& f = c.joints[i];
    EXPECT_NEAR(f.minimum, tau.col(i).minCoeff(), 1e-6 * (1.0 + std::abs(f.minimum)));
    EXPECT_NEAR(f.maximum, tau.col(i).maxCoeff(), 1e-6 * (1.0 + std::abs(f.maximum)));
    // The ends of the light filter are good to a few per cent of what changes in its 20 ms.
    EXPECT_NEAR(f.largest_speed, r.dq.col(i).cwiseAbs().maxCoeff(), 0.02 * f.largest_speed);
    EXPECT_NEAR(f.lowest, r.q.col(i).minCoeff(), 0.02 * f.travel());
    EXPECT_NEAR(f.highest, r.q.col(i).maxCoeff(), 0.02 * f.travel());
  }
}

// White noise of known size, seen through the filter, over the rms of the torque.
TEST(TheNoiseFloor, EqualsTheSimulatedNoise) {
  const Model arm = robot("scara");
  const PreprocessingOptions options;
  for (const double share : {0.02, 0.1, 0.5}) {
    const Recording clean = synthetic_recording(arm, lasting(60.0, 6.0));
    Recording r = clean;
    const MatrixXd noise = noise_like(clean.tau, share, 3);
    r.tau += noise;
    const VectorXd floor = compress(arm, r, options).noise_floor;
    ASSERT_EQ(floor.size(), 4);
    const MatrixXd tau = low_passed(r.tau, options, 200.0);
    const MatrixXd planted = low_passed(noise, options, 200.0);
    for (int i = 0; i < 4; ++i)
      EXPECT_NEAR(floor[i] / (planted.col(i).norm() / tau.col(i).norm()), 1.0, 0.15)
          << "joint " << i << ", " << share;
  }
}

TEST(TheNoiseFloor, IsUnknownWithoutARepeatingMotion) {
  const Model arm = robot("planar-2r");
  EXPECT_EQ(compress(arm, noisy(arm, lasting(20.0), 0.1, 4), {}).noise_floor.size(), 0);
}

// ---- errors
// --------------------------------------------------------------------------------------------------------

// Without a filter the errors are sums over samples that anybody can form.
TEST(PredictionErrors, EqualADirectComputation) {
  const Model arm = robot("scara");
  PreprocessingOptions options = without_edges();
  options.cutoff = 0.0;
  const Recording r = noisy(arm, lasting(22.0), 0.2, 5);
  const CompressedRecording c = compress(arm, r, options);
  const VectorXd values = 1.1 * true_parameters(arm);
  const PredictionError e = prediction_error(arm, r, options, values, c.joints).error();
  const MatrixXd ddq = differentiate(r.dq, 0.005);
  MatrixXd modelled(r.rows(), 4);
  for (Eigen::Index k = 0; k < r.rows(); ++k) {
    modelled.row(k) = full_regressor(arm, r.q.row(k).transpose(), r.dq.row(k).transpose(),
                                     ddq.row(k).transpose()) *
                      values;
  }
  const MatrixXd error = r.tau - modelled;
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(e.relative[i], error.col(i).norm() / r.tau.col(i).norm(), 1e-9);
    EXPECT_NEAR(e.maximum[i],
                error.col(i).cwiseAbs().maxCoeff() / r.tau.col(i).cwiseAbs().maxCoeff(), 1e-9);
    const auto moving =
        (r.dq.col(i).array().abs() > 0.02 * r.dq.col(i).cwiseAbs().maxCoeff()).cast<double>();
    EXPECT_NEAR(e.moving_relative[i],
                (moving * error.col(i).array()).matrix().norm() /
                    (moving * r.tau.col(i).array()).matrix().norm(),
                1e-9);
    EXPECT_NE(e.moving_relative[i], e.relative[i]);
  }
}

// Both sides of the comparison go through the filter, all samples count and not only those kept for
// the fit.
TEST(PredictionErrors, EqualThoseOfFilteredTorques) {
  const Model arm = robot("scara");
  const PreprocessingOptions options = without_edges();
  const Recording clean = synthetic_recording(arm, lasting(22.0));
  Recording r = clean;
  r.tau += noise_like(clean.tau, 0.2, 6);
  const PredictionError e =
      prediction_error(arm, r, options, true_parameters(arm), compress(arm, r, options).joints)
          .error();
  const MatrixXd tau = low_passed(r.tau, options, 200.0);
  const MatrixXd error = tau - low_passed(clean.tau, options, 200.0);
  // The light filter's ends: a few per cent of the torque for 0.1 s of 22 s, beside an error of 5
  // %.
  for (int i = 0; i < 4; ++i)
    EXPECT_NEAR(e.relative[i], error.col(i).norm() / tau.col(i).norm(), 0.1 * e.relative[i]);
}

TEST(PredictionErrors, OfSeveralRecordingsAreSummedInSquares) {
  ErrorSums a(1);
  ErrorSums b(1);
  a.torque2 << 9.0;
  a.error2 << 1.0;
  a.torque_max << 2.0;
  a.error_max << 0.5;
  b.torque2 << 16.0;
  b.error2 << 3.0;
  b.torque_max << 4.0;
  b.error_max << 0.1;
  b.moving_torque2 << 4.0;
  b.moving_error2 << 1.0;
  a.add(b);
  EXPECT_DOUBLE_EQ(a.error().relative[0], std::sqrt(4.0 / 25.0));
  EXPECT_DOUBLE_EQ(a.error().maximum[0], 0.5 / 4.0);
  EXPECT_DOUBLE_EQ(a.error().moving_relative[0], 0.5);
  EXPECT_EQ(ErrorSums(1).error().relative[0], 0.0);
}

TEST(ThePredictionSeries, IsThinnedOverItsWholeLength) {
  const Model arm = robot("planar-2r");
  for (const double seconds : {5.0, 40.0, 150.0}) {
    const Recording r = synthetic_recording(arm, lasting(seconds));
    PredictionSeries series;
    const PreprocessingOptions options = without_edges();
    prediction_error(arm, r, options, true_parameters(arm), compress(arm, r, options).joints,
                     &series);
    EXPECT_LE(series.time.size(), 6000U);
    EXPECT_GE(series.time.size(), std::min<size_t>(3000U, static_cast<size_t>(r.rows())));
    EXPECT_EQ(series.time.front(), 0.0);
    EXPECT_NEAR(series.time.back(), seconds, 0.1);
    for (const auto* table :
         {&series.q, &series.dq, &series.ddq, &series.measured, &series.modelled}) {
      ASSERT_EQ(table->size(), 2U);
      for (const auto& column : *table) EXPECT_EQ(column.size(), series.time.size());
    }
    const double step = series.time[1] - series.time[0];
    for (size_t k = 1; k < series.time.size(); ++k)
      ASSERT_NEAR(series.time[k] - series.time[k - 1], step, 1e-9);
  }
}

// ---- files
// ---------------------------------------------------------------------------------------------------------

// A file is read in pieces and its numbers have ten digits; otherwise it is the same recording.
TEST(ACompressedFile, EqualsTheCompressedRecordingInMemory) {
  const Model arm = robot("planar-2r");
  for (const MotionShape& shape : {lasting(50.0), lasting(30.0, 5.0)}) {
    const Recording r = noisy(arm, shape, 0.1, 8);
    const std::string path = testing::TempDir() + "compressed_recording_test.csv";
    write_recording(r, path);
    const CompressedRecording memory = compress(arm, r, {});
    const CompressedRecording file = compress(arm, path, {});
    const std::vector<std::string> names = parameter_names(standard_parameters(arm));
    EXPECT_EQ(file.rows, memory.rows);
    EXPECT_EQ(file.blocks.size(), memory.blocks.size());
    EXPECT_NEAR(file.period.seconds, memory.period.seconds, 1e-3);
    EXPECT_EQ(file.noise_floor.size(), memory.noise_floor.size());
    const VectorXd x = 1.1 * true_parameters(arm);
    const double expected = weighted_total(joint_totals({memory}), Eigen::Vector2d(1, 1), names).residual2(x);
    EXPECT_NEAR(weighted_total(joint_totals({file}), Eigen::Vector2d(1, 1), names).residual2(x), expected,
                1e-6 * expected);
    const VectorXd e = prediction_error(arm, path, {}, x, file.joints).error().relative;
    EXPECT_TRUE(near(e, prediction_error(arm, r, {}, x, memory.joints).error().relative, 1e-6));
    std::filesystem::remove(path);
  }
}

}  // namespace
}  // namespace veridyn
