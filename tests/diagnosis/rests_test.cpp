#include <gtest/gtest.h>

#include "diagnosis/two_joint_arm.hpp"

// Rests at the ends of recordings, in which friction balances any torque, and joints with collinear positions.

namespace veridyn {
namespace {

class AtTheEnds : public TwoJointArm {
 protected:
  // A motion with some seconds of rest before and after it, under arbitrary torques.
  static Recording with_rests(const Recording& r, double before, double after) {
    const double dt = r.time[1] - r.time[0];
    const auto first = static_cast<int>(before / dt), last = static_cast<int>(after / dt);
    Recording out = r;
    const Eigen::Index rows = first + r.rows() + last;
    out.time = VectorXd::LinSpaced(rows, 0.0, static_cast<double>(rows - 1) * dt);
    const auto held = [&](const MatrixXd& values, double share) {
      MatrixXd all(rows, values.cols());
      all.topRows(first).rowwise() = share * values.row(0);
      all.middleRows(first, r.rows()) = values;
      all.bottomRows(last).rowwise() = share * values.row(r.rows() - 1);
      return all;
    };
    out.q = held(r.q, 1.0);
    out.tau = held(r.tau, 0.5);
    if (r.dq.size() > 0) out.dq = held(r.dq, 0.0);
    if (r.ddq.size() > 0) out.ddq = held(r.ddq, 0.0);
    return out;
  }

  DiagnosisState resting(double before, double after) const {
    DiagnosisState x{read_model("planar-2r"), {}, {}, {}, {}};
    for (unsigned k = 1; k <= 3; ++k) x.train.push_back(record(k, {}));
    x.test = {record(4, {})};
    write_recording(with_rests(read_recording(x.train[1]), before, after), x.train[1]);
    x.options.identification.threads = 1;
    x.options.identification.test_preprocessing = x.options.identification.preprocessing;
    EXPECT_TRUE(fit_baseline(x));
    return x;
  }
};

TEST_F(AtTheEnds, RestsAreExcluded) {
  DiagnosisState x = resting(3.0, 2.0);
  const double moving = read_recording(x.train[0]).time.tail(1)[0];
  const double with_rests = x.start.train_error.relative.maxCoeff();
  exclude_rests(x);
  ASSERT_EQ(x.d.excluded_intervals.size(), 2U);
  for (const ExcludedInterval& part : x.d.excluded_intervals) {
    EXPECT_EQ(part.source, x.train[1]);
    EXPECT_FALSE(part.joint);
  }
  EXPECT_EQ(x.d.excluded_intervals[0].from, 0.0);
  EXPECT_NEAR(x.d.excluded_intervals[0].to, 3.0, 0.3);
  EXPECT_NEAR(x.d.excluded_intervals[1].from, 3.0 + moving, 0.3);
  EXPECT_GT(x.d.excluded_intervals[1].to, 5.0 + moving);
  EXPECT_EQ(x.options.identification.test_preprocessing->excluded_intervals.size(), 2U);
  EXPECT_LT(x.start.train_without_excluded.relative.maxCoeff(), 0.5 * with_rests);
}

// At rest dry friction holds any torque: the error of such a recording is neither a cause's nor unlike the training recordings'.
TEST_F(AtTheEnds, AHeldOutRecordingAtRestIsSaidToBeOne) {
  const std::vector<std::string> train = {record(1, {}), record(2, {}), record(3, {})};
  Recording still = read_recording(train[0]);
  still.q.rowwise() = Eigen::RowVectorXd(still.q.row(0));
  still.dq.setZero();
  still.tau = (1.5 * still.tau.row(0)).replicate(still.rows(), 1);
  still.ddq.resize(0, 0);
  write_recording(still, folder_.path("still.csv"));
  DiagnosisOptions options;
  options.identification.threads = 1;
  const Diagnosis d = diagnose(truth_, train, {folder_.path("still.csv")}, options);
  EXPECT_TRUE(d.findings.empty()) << d.report();
  EXPECT_NE(d.verdict().find("joints that hardly move in the held-out recordings: 1, 2, test on a motion"), std::string::npos) << d.verdict();
  for (const JointVerdict& v : d.joints) EXPECT_EQ(v.why.rfind("it hardly moves in the held-out recordings", 0), 0U) << v.why;
}

TEST_F(AtTheEnds, AShortRestIsNotExcluded) {
  DiagnosisState x = resting(1.9, 1.2);  // of which the filter's transients are dropped anyway, 1.2 and 0.5 s
  exclude_rests(x);
  EXPECT_TRUE(x.d.excluded_intervals.empty());
}

TEST_F(AtTheEnds, ARecordingOfPosesIsKept) {
  DiagnosisState x = resting(0.0, 0.0);
  PredictionSeries& still = x.d.baseline.train[1].series;
  for (auto* table : {&still.dq, &still.ddq}) {
    for (std::vector<double>& joint : *table) std::fill(joint.begin(), joint.end(), 0.0);
  }
  exclude_rests(x);
  EXPECT_TRUE(x.d.excluded_intervals.empty());
}

// Joints that do not move belong to no group.
TEST_F(AtTheEnds, JointsWithCollinearPositionsMoveAsOne) {
  DiagnosisState x = resting(0.0, 0.0);
  exclude_rests(x);
  EXPECT_TRUE(x.d.moving_as_one.empty());
  const auto second_follows = [&x](double share) {
    for (RecordingError& r : x.d.baseline.train) {
      for (size_t k = 0; k < r.series.time.size(); ++k) r.series.q[1][k] = 0.2 + share * r.series.q[0][k];
    }
    exclude_rests(x);
    return x.d.moving_as_one;
  };
  EXPECT_EQ(second_follows(-0.5), (std::vector<std::vector<JointIndex>>{{{0}, {1}}}));
  EXPECT_TRUE(second_follows(1e-3).empty());
}

// An arm identified from joints that move as one gives no cause; the values of a MODEL are known before.
TEST_F(AtTheEnds, NoCauseIsTestedOnJointsThatMoveAsOne) {
  DiagnosisState x = resting(0.0, 0.0);
  EXPECT_TRUE(can_attribute_errors(x));
  x.d.moving_as_one = {{{0}, {1}}};
  x.d.changes = true;
  EXPECT_TRUE(can_attribute_errors(x));
  x.d.changes = false;
  EXPECT_FALSE(can_attribute_errors(x));
  EXPECT_FALSE(x.d.has_answer());
  EXPECT_EQ(x.d.verdict().find("cannot tell: joints 1 and 2 move as one"), 0U) << x.d.verdict();
}

TEST_F(AtTheEnds, NoCauseIsTestedIfTheTorquesBelongToAnotherMotion) {
  DiagnosisState x = resting(0.0, 0.0);
  x.d.data_quality.emplace_back();
  x.d.data_quality[0].file = x.train[0];
  QualityFinding f;
  f.kind = QualityKind::kUnexplained;
  f.severity = Severity::kFault;
  f.joint = JointIndex{1};  // one joint that nothing drives
  x.d.data_quality[0].findings = {f};
  EXPECT_TRUE(can_attribute_errors(x));
  x.d.data_quality[0].findings[0].joint.reset();
  EXPECT_FALSE(can_attribute_errors(x));
  EXPECT_NE(x.d.verdict().find("cannot tell: the torques do not follow from the motion"), std::string::npos) << x.d.verdict();
}

}  // namespace
}  // namespace veridyn
