#include "veridyn/identification/robot_check.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "identification/check/answers.hpp"
#include "identification/check/questions.hpp"
#include "identification/check/quick_fit.hpp"
#include "identification/synthetic_recording.hpp"
#include "recordings/signals/units.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn {
namespace {

// Recordings of arms with bodies and friction, mistaken on purpose, with 3 % of noise.
class AMistakenRecording : public testing::Test {
 protected:
  void SetUp() override {
    path_ = testing::TempDir() + "veridyn-mistaken-" + std::to_string(::getpid()) + ".csv";
  }
  void TearDown() override { std::filesystem::remove(path_); }

  Recording recorded(const std::string& robot, unsigned seed) {
    arm_.emplace(read_model(robot));
    const Model plausible = plausible_model(*arm_, seed).arm;
    MotionShape shape;
    shape.duration = 20.0;
    shape.rate = 100.0;
    shape.seed = seed;
    Recording r = synthetic_recording(plausible, shape);
    r.tau += noise_like(r.tau, 0.03, seed);
    return r;
  }

  // Findings as "finding:joint", and whether the option that each names mends the recording.
  std::vector<std::string> findings(const Recording& r, const PreprocessingOptions& options = {}) {
    write_recording(r, path_);
    std::vector<std::string> out;
    sentences_.clear();
    for (const QualityFinding& f : check_against(*arm_, path_, options)) {
      if (f.kind == QualityKind::kWeakMotion) continue;  // a warning, about the motion
      out.push_back(std::string(name_of(f.kind)) + ":" + std::to_string(f.joint ? f.joint->value + 1 : 0));
      sentences_ += f.sentence + "\n";
    }
    return out;
  }

  std::string path_;
  std::optional<Model> arm_;
  std::string sentences_;
};

using Names = std::vector<std::string>;

TEST_F(AMistakenRecording, IsNotReportedForACorrectOne) {
  for (const char* robot : {"psm-3dof", "elbow-6r", "scara"})
    EXPECT_EQ(findings(recorded(robot, 3)), Names{}) << robot << "\n" << sentences_;
}

// In the first part the joints move as far as they do anywhere, so that the rest cannot predict it; nothing is wrong with it.
TEST_F(AMistakenRecording, IsNotReportedWhereAPartCannotBePredictedFromTheOthers) {
  for (const char* robot : {"psm-3dof", "scara"}) {
    for (unsigned seed = 1; seed <= 4; ++seed) {
      arm_.emplace(read_model(robot));
      const Model wide = plausible_model(*arm_, seed).arm;
      ModelDescription narrow = wide.description();
      for (Coordinate& c : narrow.coordinates) {
        const double middle = 0.5 * (c.limits.lower + c.limits.upper), half = 0.05 * (c.limits.upper - c.limits.lower);
        if (std::isfinite(half)) c.limits.lower = middle - half, c.limits.upper = middle + half;
      }
      MotionShape shape;
      shape.duration = 4.0;
      shape.rate = 100.0;
      shape.seed = seed;
      Recording r = synthetic_recording(wide, shape);
      shape.duration = 16.0;
      const Recording rest = synthetic_recording(Model(std::move(narrow)), shape);
      const auto below = [](const MatrixXd& a, const MatrixXd& b) { return (MatrixXd(a.rows() + b.rows(), a.cols()) << a, b).finished(); };
      r.time = below(r.time, rest.time.array() + 5.0);
      r.q = below(r.q, rest.q);
      r.dq = below(r.dq, rest.dq);
      r.tau = below(r.tau, rest.tau);
      r.tau += noise_like(r.tau, 0.03, seed);
      EXPECT_EQ(findings(r), Names{}) << robot << " " << seed << "\n" << sentences_;
    }
  }
}

// Standing still, moving one joint only, or too short: none of it tells signs or order.
TEST_F(AMistakenRecording, IsNotReportedIfTheMotionDoesNotDetermineIt) {
  for (const char* robot : {"psm-3dof", "elbow-6r"}) {
    const Recording sound = recorded(robot, 11);
    Recording still = sound;
    for (int i = 0; i < still.joints(); ++i) {
      still.q.col(i) = 0.3 + 1e-4 * noise_like(still.q, 1.0, 12).col(i).array();
      still.dq.col(i) = 1e-3 * noise_like(still.dq, 1.0, 13).col(i);
      still.tau.col(i).setConstant(-0.2 * (i + 1));
    }
    EXPECT_EQ(findings(still), Names{}) << robot << "\n" << sentences_;
    // As at constant velocity: the last joint slides, the others hold against it.
    Recording one = still;
    const int last = one.joints() - 1;
    one.q.col(last) = sound.q.col(last);
    one.dq.col(last) = sound.dq.col(last);
    one.tau.col(last) = sound.tau.col(last);
    EXPECT_EQ(findings(one), Names{"not_compared:0"}) << robot << "\n" << sentences_;
    for (const int rows : {300, 500}) {
      for (const std::string& name : findings(rows_of(sound, 0, rows)))
        EXPECT_EQ(name, "not_compared:0") << robot << " " << rows << "\n" << sentences_;
    }
  }
}

// What the sentence of a fault says, the fit bears out: less is left unexplained than before.
TEST_F(AMistakenRecording, IsReportedWithTheErrorsBeforeAndAfterCorrection) {
  Recording r = recorded("elbow-6r", 14);
  r.tau.col(1) *= -1.0;
  r.tau.col(3) *= -1.0;
  ASSERT_EQ(findings(r), (Names{"torque_sign:2", "torque_sign:4"})) << sentences_;
  std::istringstream lines(sentences_);
  for (std::string line; std::getline(lines, line);) {
    const auto now = line.find("leaves ");
    const auto before = line.find("instead of ");
    if (now == std::string::npos) continue;
    EXPECT_LT(std::stod(line.substr(now + 7)), std::stod(line.substr(before + 11))) << line;
  }
}

TEST_F(AMistakenRecording, WithOneReversedTorqueIsCorrectedByTheUnitsOption) {
  for (const char* robot : {"psm-3dof", "elbow-6r"}) {
    Recording r = recorded(robot, 4);
    r.tau.col(1) *= -1.0;
    EXPECT_EQ(findings(r), Names{"torque_sign:2"}) << robot << "\n" << sentences_;
    EXPECT_NE(sentences_.find("--units tau2=-Nm mends it"), std::string::npos) << sentences_;
    PreprocessingOptions mended;
    mended.signals.units["tau2"] = "-Nm";
    EXPECT_EQ(findings(r, mended), Names{}) << sentences_;
  }
}

TEST_F(AMistakenRecording, WithAllTorquesNegatedIsDetectedByItsFriction) {
  Recording r = recorded("psm-3dof", 5);
  r.tau *= -1.0;
  EXPECT_EQ(findings(r), Names{"torque_sign:0"}) << sentences_;
  EXPECT_NE(sentences_.find("--units tau=-Nm mends it"), std::string::npos) << sentences_;
}

TEST_F(AMistakenRecording, WithSwappedTorquesIsCorrectedByTheMapOption) {
  Recording r = recorded("elbow-6r", 6);
  r.tau.col(1).swap(r.tau.col(2));
  EXPECT_EQ(findings(r), Names{"swapped_joints:2"}) << sentences_;
  EXPECT_NE(sentences_.find("--map tau2=tau3,tau3=tau2 mends it"), std::string::npos) << sentences_;
  PreprocessingOptions mended;
  mended.signals.map = {{"tau2", "tau3"}, {"tau3", "tau2"}};
  EXPECT_EQ(findings(r, mended), Names{}) << sentences_;
}

TEST_F(AMistakenRecording, WithSwappedMotionIsCorrectedByTheMapOption) {
  Recording r = recorded("elbow-6r", 7);
  r.q.col(1).swap(r.q.col(2));
  r.dq.col(1).swap(r.dq.col(2));
  EXPECT_EQ(findings(r), Names{"swapped_joints:2"}) << sentences_;
  EXPECT_NE(sentences_.find("--map q2=q3,q3=q2,dq2=dq3,dq3=dq2 mends it"), std::string::npos) << sentences_;
}

TEST_F(AMistakenRecording, InDegreesIsCorrectedByTheUnitsOption) {
  Recording r = recorded("elbow-6r", 8);
  r.q *= 180.0 / M_PI;
  r.dq *= 180.0 / M_PI;
  EXPECT_EQ(findings(r), Names{"degrees:0"}) << sentences_;
  EXPECT_NE(sentences_.find("--units q=deg,dq=deg/s mends it"), std::string::npos) << sentences_;
}

// One joint's driver publishes degrees, or the position of its motor; all others are right.
TEST_F(AMistakenRecording, WithOneJointInAnotherUnitIsCorrectedByTheUnitsOption) {
  Recording r = recorded("elbow-6r", 8);
  r.q.col(2) *= 180.0 / M_PI;
  r.dq.col(2) *= 180.0 / M_PI;
  EXPECT_EQ(findings(r), Names{"degrees:3"}) << sentences_;
  EXPECT_NE(sentences_.find("--units q3=deg,dq3=deg/s mends it"), std::string::npos) << sentences_;
  r = recorded("elbow-6r", 8);
  r.q.col(1) *= 31.0;
  r.dq.col(1) *= 31.0;
  EXPECT_EQ(findings(r), Names{"motor_side:2"}) << sentences_;
  EXPECT_NE(sentences_.find("in front of a gear of about 31"), std::string::npos) << sentences_;
}

// An arm that turns and slides, in degrees and millimetres: no option of one undoes the other's.
TEST_F(AMistakenRecording, InDegreesAndMillimetresIsCorrectedByTheUnitsOptionForBoth) {
  Recording r = recorded("psm-3dof", 8);
  for (MatrixXd* values : {&r.q, &r.dq}) {
    values->leftCols(2) *= 180.0 / M_PI;
    values->col(2) *= 1000.0;
  }
  EXPECT_EQ(findings(r), Names{"millimetres:0"}) << sentences_;
  EXPECT_NE(sentences_.find("--units q=deg,dq=deg/s,q3=mm,dq3=mm/s mends it"), std::string::npos) << sentences_;
  PreprocessingOptions mended;
  mended.signals.units = {{"q", "deg"}, {"dq", "deg/s"}, {"q3", "mm"}, {"dq3", "mm/s"}};
  EXPECT_EQ(findings(r, mended), Names{}) << sentences_;
}

// What no question explains is said to be unexplained, and no sign or unit is blamed for it.
TEST_F(AMistakenRecording, WithTorquesOfAnotherMotionIsReportedAsUnexplained) {
  Recording r = recorded("elbow-6r", 12);
  r.tau = recorded("elbow-6r", 17).tau;
  EXPECT_EQ(findings(r), Names{"unexplained:0"}) << sentences_;
}

// A torque that is cut off makes many units a little better, and none right.
TEST_F(AMistakenRecording, WithAClippedTorqueIsNotReportedAsAnotherUnit) {
  Recording r = recorded("elbow-6r", 4);
  const double most = 0.5 * r.tau.col(1).cwiseAbs().maxCoeff();
  r.tau.col(1) = r.tau.col(1).cwiseMax(-most).cwiseMin(most);
  for (const std::string& name : findings(r)) EXPECT_EQ(name.rfind("unexplained", 0), 0U) << sentences_;
}

// Every position lies within its joint's limits, which in degrees it would leave.
TEST_F(AMistakenRecording, InDegreesWithinTheLimitsIsOnlySuspected) {
  Recording r = recorded("elbow-6r", 8);
  r.q *= 180.0 / M_PI;
  r.dq *= 180.0 / M_PI;
  ModelDescription d = arm_->description();
  for (Coordinate& c : d.coordinates) {
    c.limits.lower = -1e3;
    c.limits.upper = 1e3;
  }
  arm_.emplace(Model(std::move(d)));
  findings(r);
  EXPECT_EQ(sentences_.find("mends it"), std::string::npos) << sentences_;
  EXPECT_NE(sentences_.find("Perhaps positions and velocities are degrees"), std::string::npos) << sentences_;
}

TEST_F(AMistakenRecording, OfCurrentsIsDetectedByAnArmWithValues) {
  Recording r = recorded("elbow-6r", 9);
  ModelDescription d = plausible_model(*arm_, 9).arm.description();
  for (Coordinate& c : d.coordinates) c.drive_gain = 11.0;
  arm_.emplace(Model(std::move(d)));
  EXPECT_EQ(findings(r), Names{}) << sentences_;
  r.tau /= 11.0;
  EXPECT_EQ(findings(r), Names{"current:0"}) << sentences_;
  EXPECT_NE(sentences_.find("--units tau=A mends it"), std::string::npos) << sentences_;
}

// Gains that differ from joint to joint are told from the fit alone.
TEST_F(AMistakenRecording, OfCurrentsIsDetectedByDifferingGains) {
  Recording r = recorded("elbow-6r", 10);
  ModelDescription d = arm_->description();
  for (int i = 0; i < 6; ++i) {
    d.coordinates[i].drive_gain = 12.0 - i;
    r.tau.col(i) /= 12.0 - i;
  }
  arm_.emplace(Model(std::move(d)));
  EXPECT_EQ(findings(r), Names{"current:0"}) << sentences_;
}

// One motor counts the other way round, in its position and in its torque: neither alone explains anything.
TEST_F(AMistakenRecording, OfAMotorWithTheOppositeSignIsCorrectedByUnits) {
  Recording r = recorded("elbow-6r", 31);
  for (MatrixXd* values : {&r.q, &r.dq, &r.tau}) values->col(1) *= -1.0;
  EXPECT_EQ(findings(r), Names{"position_sign:2"}) << sentences_;
  EXPECT_NE(sentences_.find("--units q2=-rad,dq2=-rad/s,tau2=-Nm mends it"), std::string::npos) << sentences_;
}

// The option that undoes a zero beside that of the robot file.
TEST(AnOffset, InAUnitIsSubtractedBeforeTheConversion) {
  EXPECT_NEAR((*recordings::unit_scale("q", "rad@1.5"))(2.0), 0.5, 1e-12);
  EXPECT_NEAR((*recordings::unit_scale("q", "deg@90"))(180.0), 0.5 * M_PI, 1e-12);
  EXPECT_NEAR((*recordings::unit_scale("q", "4096/rev@2048"))(3072.0), 0.5 * M_PI, 1e-12);
  for (const char* unit : {"rad@", "rad@x", "@1", "rad@1@2"}) EXPECT_FALSE(recordings::unit_scale("q", unit)) << unit;
  EXPECT_FALSE(recordings::unit_scale("tau", "Nm@1"));
}

TEST_F(AMistakenRecording, InTurnsIsCorrectedByTheUnitsOption) {
  Recording r = recorded("elbow-6r", 33);
  r.q /= 2.0 * M_PI;
  r.dq *= 30.0 / M_PI;
  EXPECT_EQ(findings(r), Names{"turns:0"}) << sentences_;
  EXPECT_NE(sentences_.find("--units q=rev,dq=rpm mends it"), std::string::npos) << sentences_;
}

TEST_F(AMistakenRecording, WithOneTorqueInAnotherUnitIsCorrectedByTheUnitsOption) {
  Recording r = recorded("elbow-6r", 34);
  r.tau.col(2) *= 1e3;
  EXPECT_EQ(findings(r), Names{"torque_unit:3"}) << sentences_;
  EXPECT_NE(sentences_.find("--units tau3=mNm mends it"), std::string::npos) << sentences_;
}

// Signs of single joints beside the unit of all: the options undo both.
TEST_F(AMistakenRecording, InDegreesAndReversedIsCorrectedByTwoOptions) {
  Recording r = recorded("elbow-6r", 35);
  for (MatrixXd* values : {&r.q, &r.dq}) {
    *values *= 180.0 / M_PI;
    values->col(1) *= -1.0;
  }
  EXPECT_EQ(findings(r), (Names{"degrees:0", "position_sign:2"})) << sentences_;
  EXPECT_NE(sentences_.find("--units q=deg,dq=deg/s,q2=-deg,dq2=-deg/s mends it"), std::string::npos) << sentences_;
}

TEST_F(AMistakenRecording, WithoutVelocitiesIsCheckedWithDerivatives) {
  Recording r = recorded("elbow-6r", 36);
  r.dq.setZero();
  EXPECT_EQ(findings(r), Names{}) << sentences_;
  r.tau.col(1) *= -1.0;
  EXPECT_EQ(findings(r), Names{"torque_sign:2"}) << sentences_;
}

// As drivers of Universal Robots publish their joints.
TEST_F(AMistakenRecording, InTheOrderOfNamesIsCorrectedByTheMapOption) {
  const Recording sound = recorded("elbow-6r", 38);
  ModelDescription d = arm_->description();
  for (int i = 0; i < 6; ++i) d.coordinates[static_cast<std::size_t>(i)].name = std::string(1, "cadbef"[i]);
  arm_.emplace(Model(std::move(d)));
  Recording r = sound;
  for (const auto& [joint, column] : {std::pair<int, int>{0, 2}, {1, 0}, {2, 3}, {3, 1}}) {
    r.q.col(column) = sound.q.col(joint);
    r.dq.col(column) = sound.dq.col(joint);
    r.tau.col(column) = sound.tau.col(joint);
  }
  EXPECT_EQ(findings(r), Names{"swapped_joints:0"}) << sentences_;
  EXPECT_NE(sentences_.find("tau1=tau3,tau2=tau1,tau3=tau4,tau4=tau2 mends it"), std::string::npos) << sentences_;
  r = sound;
  for (int i = 0; i < 6; ++i) r.tau.col((i + 1) % 6) = sound.tau.col(i);
  EXPECT_EQ(findings(r), Names{"swapped_joints:0"}) << sentences_;
  EXPECT_NE(sentences_.find("one column too far to the right"), std::string::npos) << sentences_;
}

TEST_F(AMistakenRecording, OfAnUndrivenJointIsReported) {
  Recording r = recorded("elbow-6r", 39);
  r.tau.col(4) = 0.01 * noise_like(r.tau, 1.0, 40).col(4);
  EXPECT_EQ(findings(r), Names{"unexplained:5"}) << sentences_;
}

// Small errors are what an arm lacks, and no exchange of its joints: an amplifier with a small dead zone.
TEST_F(AMistakenRecording, IsNotReportedForASmallError) {
  Recording r = recorded("scara", 37);
  for (double& t : r.tau.col(1)) t = std::copysign(std::max(0.0, std::abs(t) - 0.1), t);
  for (const std::string& name : findings(r)) EXPECT_NE(name.rfind("swapped_joints", 0), 0U) << sentences_;
}

// The arm of a file with values, which differ from the truth as those of a manufacturer do.
class ARobotFile : public AMistakenRecording {
 protected:
  Recording recorded_beside_values(const std::string& robot, unsigned seed) {
    Recording r = recorded(robot, seed);
    const Model truth = plausible_model(*arm_, seed).arm;
    ModelDescription d = truth.description();
    for (Frame& frame : d.frames) {
      if (frame.body && frame.body->phi) *frame.body->phi *= 1.2;
    }
    d.effects.clear();
    arm_.emplace(Model(std::move(d)));
    return r;
  }

  // What recordings of a mistaken arm say beside the file, and that the option is named.
  void expect(const Recording& r, const Names& names, const std::string& option) {
    EXPECT_EQ(findings(r), names) << sentences_;
    EXPECT_NE(sentences_.find(option + " mends it"), std::string::npos) << sentences_;
  }
};

TEST_F(ARobotFile, WithoutFrictionCausesNoFinding) {
  Recording r = recorded_beside_values("elbow-6r", 21);
  EXPECT_EQ(findings(r), Names{}) << sentences_;
  r.tau *= 1.4;
  EXPECT_EQ(findings(r), Names{}) << sentences_;
}

TEST_F(ARobotFile, WithValuesRevealsTheUnitOfTorques) {
  const Recording sound = recorded_beside_values("elbow-6r", 22);
  Recording r = sound;
  r.tau *= 1e3;
  expect(r, {"torque_unit:0"}, "--units tau=mNm");
  ModelDescription d = arm_->description();
  r = sound;
  for (int i = 0; i < 6; ++i) {
    d.coordinates[static_cast<size_t>(i)].limits.effort = 150.0 - 20.0 * i;
    r.tau.col(i) *= 100.0 / (150.0 - 20.0 * i);
  }
  arm_.emplace(Model(std::move(d)));
  expect(r, {"torque_unit:0"}, "--units tau=%");
  r = sound;
  r.tau *= -1.0;
  expect(r, {"torque_sign:0"}, "--units tau=-Nm");
}

TEST_F(ARobotFile, WithEffortLimitsRevealsTorquesBeyondThem) {
  const Recording r = recorded_beside_values("elbow-6r", 22);
  ModelDescription d = arm_->description();
  for (int i = 0; i < 6; ++i) d.coordinates[static_cast<size_t>(i)].limits.effort = (i == 2 ? 0.2 : 1.2) * r.tau.col(i).cwiseAbs().maxCoeff();
  arm_.emplace(Model(std::move(d)));
  EXPECT_EQ(findings(r), Names{"beyond_effort:3"}) << sentences_;
}

// Masses in grams in the robot file: in kN m the torques would be beyond its efforts.
TEST_F(ARobotFile, WithNarrowLimitsRevealsPositionsAndSpeedsBeyondThem) {
  const Recording r = recorded("elbow-6r", 33);
  ModelDescription d = arm_->description();
  d.coordinates[1].limits.lower *= 0.1;
  d.coordinates[1].limits.upper *= 0.1;
  d.coordinates[2].limits.velocity = 0.1 * r.dq.col(2).cwiseAbs().maxCoeff();
  arm_.emplace(std::move(d));
  EXPECT_EQ(findings(r), (Names{"beyond_limits:2", "beyond_speed:3"})) << sentences_;
}

// A force that depends on other joints' speeds, as no parameter of the arm does.
TEST_F(ARobotFile, ThatLacksAPartOfATorqueIsReported) {
  Recording r = recorded("elbow-6r", 34);
  r.tau.col(2) += (10.0 * r.tau.col(2).norm() / r.dq.col(1).norm() * (3.0 * r.time.array()).sin() * r.dq.col(1).array()).matrix() * 0.05;
  EXPECT_EQ(findings(r), Names{"unexplained:3"}) << sentences_;
  EXPECT_NE(sentences_.find("With all its parameters free"), std::string::npos) << sentences_;
}

TEST_F(ARobotFile, DoesNotSuggestATorqueUnitThatItsEffortsExclude) {
  const Recording r = recorded_beside_values("elbow-6r", 22);
  ModelDescription d = arm_->description();
  for (Frame& f : d.frames) {
    if (f.body && f.body->phi) *f.body->phi *= 1000.0;
  }
  for (Coordinate& c : d.coordinates) c.limits.effort = 1.2 * r.tau.cwiseAbs().maxCoeff();
  arm_.emplace(Model(std::move(d)));
  findings(r);
  EXPECT_EQ(sentences_.find("mends it"), std::string::npos) << sentences_;
  EXPECT_NE(sentences_.find("are its masses in another unit"), std::string::npos) << sentences_;
}

TEST_F(ARobotFile, WithGearsRevealsTorquesMeasuredBeforeThem) {
  Recording r = recorded_beside_values("elbow-6r", 23);
  r.tau /= 121.0;
  EXPECT_EQ(findings(r), Names{"torque_unit:0"}) << sentences_;
  EXPECT_NE(sentences_.find("in front of gears of about 1"), std::string::npos) << sentences_;
}

TEST_F(ARobotFile, WithAWrongGravityDirectionIsReported) {
  const Recording sound = recorded_beside_values("elbow-6r", 24);
  const auto mounted = [&](const Eigen::Vector3d& gravity) {
    ModelDescription d = arm_->description();
    d.gravity = gravity;
    return Model(std::move(d));
  };
  const Eigen::Vector3d g = arm_->gravity();
  const Model upright = *arm_;
  for (const Eigen::Vector3d& file : {Eigen::Vector3d(0, -9.81, 0), Eigen::Vector3d(-g), Eigen::Vector3d(Eigen::AngleAxisd(0.35, Eigen::Vector3d(1, 2, 0).normalized()) * g)}) {
    arm_.emplace(mounted(file));
    EXPECT_EQ(findings(sound), Names{"gravity:0"}) << file.transpose() << "\n" << sentences_;
    EXPECT_NE(sentences_.find("mends it"), std::string::npos) << sentences_;
    arm_.emplace(upright);
  }
  arm_.emplace(mounted({0, 0, 0}));
  EXPECT_EQ(findings(sound), Names{"gravity:0"}) << sentences_;
}

TEST_F(AMistakenRecording, WithOneWrongUnitIsCorrectedByTheSuggestedOption) {
  const Recording sound = recorded("elbow-6r", 25);
  Recording r = sound;
  r.q *= 180.0 / M_PI;
  EXPECT_EQ(findings(r), Names{"degrees:0"}) << sentences_;
  EXPECT_NE(sentences_.find("--units q=deg mends it"), std::string::npos) << sentences_;
  r = sound;
  r.dq *= 180.0 / M_PI;
  EXPECT_EQ(findings(r), Names{"degrees:0"}) << sentences_;
  EXPECT_NE(sentences_.find("--units dq=deg/s mends it"), std::string::npos) << sentences_;
  r = sound;
  r.q = (r.q.array() * (4096.0 / (2.0 * M_PI)) + 2048.0).round();
  EXPECT_EQ(findings(r), Names{"counts:0"}) << sentences_;
  EXPECT_NE(sentences_.find("--units q=4096/rev@2048"), std::string::npos) << sentences_;
  r = sound;
  r.q *= 100.0;
  r.dq *= 100.0;
  EXPECT_EQ(findings(r), Names{"motor_side:0"}) << sentences_;
  EXPECT_NE(sentences_.find("--units q=0.01,dq=0.01 "), std::string::npos) << sentences_;
}

TEST_F(AMistakenRecording, WithTwoMistakesIsCorrectedByBothOptions) {
  Recording r = recorded("elbow-6r", 26);
  r.q *= 180.0 / M_PI;
  r.dq *= 180.0 / M_PI;
  r.tau.col(1) *= -1.0;
  EXPECT_EQ(findings(r), (Names{"degrees:0", "torque_sign:2"})) << sentences_;
  EXPECT_NE(sentences_.find("--units q=deg,dq=deg/s,tau2=-Nm mends it"), std::string::npos) << sentences_;
}

TEST_F(AMistakenRecording, WithAnExchangedWristIsCorrectedByTheMapOption) {
  Recording r = recorded("elbow-6r", 27);
  for (MatrixXd* values : {&r.q, &r.dq, &r.tau}) values->col(4).swap(values->col(5));
  EXPECT_EQ(findings(r), Names{"swapped_joints:5"}) << sentences_;
  EXPECT_NE(sentences_.find("--map q5=q6,q6=q5,dq5=dq6,dq6=dq5,tau5=tau6,tau6=tau5 mends it"), std::string::npos) << sentences_;
}

// The rows of the file are written in the other convention.
TEST_F(AMistakenRecording, OnRowsOfTheOtherConventionIsReportedAsDhConventionOnly) {
  const Recording r = recorded("psm-3dof", 28);
  ModelDescription d = arm_->description();
  for (Frame& frame : d.frames) {
    if (!frame.dh) continue;
    DhRow row = *frame.dh;
    if (frame.type == JointType::kRevolute) frame.variable.offset -= row.theta;
    if (frame.type == JointType::kPrismatic) frame.variable.offset -= row.d;
    row.convention = row.convention == DhConvention::kStandard ? DhConvention::kModified : DhConvention::kStandard;
    place(frame, row);
  }
  arm_.emplace(Model(std::move(d)));
  EXPECT_EQ(findings(r), Names{"dh_convention:0"}) << sentences_;
  EXPECT_NE(sentences_.find("in the robot file mends it"), std::string::npos) << sentences_;
}

// A torque that no transformation explains: what helps is said to be not the whole truth.
TEST_F(AMistakenRecording, ThatIsOnlyPartlyExplainedIsNotCorrected) {
  Recording r = recorded("elbow-6r", 29);
  r.tau.col(2) += 4.0 * r.tau.col(2).cwiseAbs().mean() * (3.0 * r.q.col(2)).array().sin().matrix();
  r.tau.col(1) *= -1.0;
  findings(r);
  EXPECT_EQ(sentences_.find("mends it"), std::string::npos) << sentences_;
  EXPECT_NE(sentences_.find("not the whole truth"), std::string::npos) << sentences_;
}

// Efforts of drives whose gains nobody wrote down.
TEST_F(AMistakenRecording, OfCurrentsWithoutGainsIsCorrectedByTheUnitsOption) {
  const double gains[] = {9.0, 10.0, 8.5, 3.0, 2.0, 2.5};
  Recording r = recorded("elbow-6r", 41);
  for (int i = 0; i < 6; ++i) r.tau.col(i) /= gains[i];
  EXPECT_EQ(findings(r), Names{"torque_unit:0"}) << sentences_;
  EXPECT_NE(sentences_.find("in a unit of their own on each joint"), std::string::npos) << sentences_;
  EXPECT_NE(sentences_.find(" mends it"), std::string::npos) << sentences_;
  PreprocessingOptions mended;
  for (int i = 0; i < 6; ++i) mended.signals.units["tau" + std::to_string(i + 1)] = std::to_string(gains[i]);
  EXPECT_EQ(findings(r, mended), Names{}) << sentences_;
}

// Velocities that are not those of the positions are left to the check of velocities.
TEST_F(AMistakenRecording, WithNegatedVelocitiesIsNotReportedAsAnotherUnit) {
  const Recording sound = recorded("elbow-6r", 42);
  Recording r = sound;
  r.dq *= -1.0;
  findings(r);
  EXPECT_EQ(sentences_.find("mends it"), std::string::npos) << sentences_;
  r = sound;
  r.dq.col(1) *= 180.0 / M_PI;
  findings(r);
  EXPECT_EQ(sentences_.find("mends it"), std::string::npos) << sentences_;
}

// The arm rests between its motions on closed brakes, without torques of its motors.
TEST_F(AMistakenRecording, WithClosedBrakesIsCorrectedByTheMinSpeedOption) {
  const Recording sound = recorded("elbow-6r", 43);
  const int half = sound.rows() / 2, pause = 300;
  std::vector<int> rows;
  for (int k = 0; k < sound.rows() + pause; ++k) rows.push_back(k < half ? k : std::max(half, k - pause));
  Recording r = sound;
  r.q = sound.q(rows, Eigen::all);
  r.dq = sound.dq(rows, Eigen::all);
  r.tau = sound.tau(rows, Eigen::all);
  r.ddq.resize(0, 0);
  r.time = 0.01 * VectorXd::LinSpaced(r.q.rows(), 0.0, static_cast<double>(r.q.rows() - 1));
  r.dq.middleRows(half, pause).setZero();
  r.tau.middleRows(half, pause) *= 1e-3;
  EXPECT_EQ(findings(r), Names{"brakes:0"}) << sentences_;
  EXPECT_NE(sentences_.find("--min-speed 0.01 mends it"), std::string::npos) << sentences_;
}

TEST_F(AMistakenRecording, WithAbsoluteValuesOfOneTorqueHasNoSign) {
  Recording r = recorded("elbow-6r", 44);
  r.tau.col(1) = -r.tau.col(1).cwiseAbs();
  EXPECT_EQ(findings(r), Names{"no_sign:2"}) << sentences_;
}

// A shoulder that moves over a fifth of its range: gravity there is nearly a straight line, as a spring is.
TEST_F(AMistakenRecording, OfASmallMotionIsReportedAsWeakMotion) {
  const auto weak = [this](double share) {
    arm_.emplace(read_model("planar-2r"));
    const Model plausible = plausible_model(*arm_, 30).arm;
    MotionShape shape;
    shape.duration = 20.0;
    shape.rate = 100.0;
    shape.seed = 30;
    Recording r = synthetic_recording(plausible, shape);
    r.q *= share;  // the torques have no part in this
    r.dq *= share;
    bool out = false;
    for (const QualityFinding& f : check_against(*arm_, r)) out = out || (f.kind == QualityKind::kWeakMotion && f.sentence.find("a spring and a load cannot be told apart") != std::string::npos);
    return out;
  };
  EXPECT_TRUE(weak(0.2));
  EXPECT_FALSE(weak(0.8));
}

// The torques of a joint (from 0), or of all, as measured at other times.
template <typename When>
void shift_torques(Recording& r, const When& when, int joint = -1) {
  const MatrixXd tau = r.tau;
  for (Eigen::Index k = 0; k < r.rows(); ++k) {
    const double row = std::clamp(when(r.time[k]), r.time[0], r.time[r.rows() - 1]) / (r.time[1] - r.time[0]);
    const auto before = std::min(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(r.rows()) - 2);
    for (int i = 0; i < r.joints(); ++i) {
      if (joint < 0 || joint == i) r.tau(k, i) = tau(before, i) + (row - static_cast<double>(before)) * (tau(before + 1, i) - tau(before, i));
    }
  }
}

TEST_F(AMistakenRecording, WithLateTorquesIsNamedWithTheDelay) {
  const Recording sound = recorded("elbow-6r", 21);
  const auto delay_after = [this](const std::string& words) { return std::stod(sentences_.substr(sentences_.find(words) + words.size())); };
  Recording r = sound;
  shift_torques(r, [](double t) { return t - 0.08; });
  EXPECT_EQ(findings(r), Names{"torque_delay:0"}) << sentences_;
  EXPECT_NEAR(delay_after("measured "), 80.0, 3.0) << sentences_;
  EXPECT_NE(sentences_.find("earlier mends it"), std::string::npos) << sentences_;
  r = sound;
  shift_torques(r, [](double t) { return t - 0.06; }, 2);
  EXPECT_EQ(findings(r), Names{"torque_delay:3"}) << sentences_;
  EXPECT_NEAR(delay_after("measured "), 60.0, 3.0) << sentences_;
  // Positions that are commanded and not measured come first.
  r = sound;
  shift_torques(r, [](double t) { return t + 0.05; });
  EXPECT_EQ(findings(r), Names{"torque_delay:0"}) << sentences_;
  EXPECT_NE(sentences_.find("before the motion"), std::string::npos) << sentences_;
}

TEST_F(AMistakenRecording, WithAnotherClockForTorquesIsReported) {
  Recording r = recorded("elbow-6r", 22);
  shift_torques(r, [](double t) { return 0.985 * t; });  // 0.3 s late after 20 s
  EXPECT_EQ(findings(r), Names{"torque_clock:0"}) << sentences_;
  EXPECT_NE(sentences_.find("by another clock"), std::string::npos) << sentences_;
  EXPECT_NE(sentences_.find("one clock for both mends it"), std::string::npos) << sentences_;
}

// An exponential filter of 1 Hz, as drivers have.
TEST_F(AMistakenRecording, WithFilteredTorquesIsNamedWithTheCutOff) {
  Recording r = recorded("elbow-6r", 23);
  const double kept = std::exp(-2.0 * M_PI * 1.0 * (r.time[1] - r.time[0]));
  for (Eigen::Index k = 1; k < r.rows(); ++k) r.tau.row(k) = kept * r.tau.row(k - 1) + (1.0 - kept) * r.tau.row(k);
  EXPECT_EQ(findings(r), Names{"torque_filter:0"}) << sentences_;
  EXPECT_NE(sentences_.find("a low-pass of about 1 Hz"), std::string::npos) << sentences_;
}

// An offset that steps, a load that is picked up, a sensor that fails: the rest of the recording is used.
TEST_F(AMistakenRecording, WithAChangeMidwayIsCorrectedByTheRowsOption) {
  const Recording sound = recorded("elbow-6r", 23);
  const int moment = 1240;  // of 2000 rows
  Recording stepped = sound, failed = sound, loaded = sound, late = sound;
  stepped.tau.col(1).tail(sound.rows() - moment).array() += 0.5 * std::sqrt(sound.tau.col(1).array().square().mean());
  failed.tau.col(1).tail(sound.rows() - moment).setConstant(sound.tau(moment, 1));
  loaded.tau.bottomRows(sound.rows() - moment) *= 1.3;
  for (const Recording* r : {&stepped, &failed, &loaded}) {
    EXPECT_EQ(findings(*r), Names{"changed_midway:0"}) << sentences_;
    EXPECT_NE(sentences_.find("Something after 11.2 s does not fit with the rows before"), std::string::npos) << sentences_;
    EXPECT_NE(sentences_.find("--rows 0:1125 mends it"), std::string::npos) << sentences_;
  }
  Recording silent = sound;
  silent.tau.bottomRows(sound.rows() - moment).setZero();
  EXPECT_EQ(findings(silent), Names{"changed_midway:0"}) << sentences_;
  late.tau.topRows(700) *= 1.3;
  EXPECT_EQ(findings(late), Names{"changed_midway:0"}) << sentences_;
}

// Nothing but the values of an identified model tells which part is sound, and it need not be the longer one.
TEST_F(AMistakenRecording, KeepsThePartThatTheModelExplains) {
  arm_.emplace(read_model("elbow-6r"));
  const Model plausible = plausible_model(*arm_, 23).arm;
  MotionShape shape;
  shape.duration = 20.0;
  shape.rate = 100.0;
  shape.period = 5.0;
  shape.seed = 23;
  Recording r = synthetic_recording(plausible, shape);
  r.tau += noise_like(r.tau, 0.03, 23);
  r.tau.bottomRows(r.rows() - 875) *= 1.3;
  ModelDescription without_friction = arm_->description();
  without_friction.effects.clear();
  arm_.emplace(std::move(without_friction));
  EXPECT_EQ(findings(r), Names{"changed_midway:0"}) << sentences_;
  EXPECT_NE(sentences_.find("mends it, and so does --rows 0:"), std::string::npos) << sentences_;
  arm_ = plausible;
  EXPECT_EQ(findings(r), Names{"changed_midway:0"}) << sentences_;
  EXPECT_NE(sentences_.find("; --rows 0:"), std::string::npos) << sentences_;
  EXPECT_EQ(sentences_.find("so does"), std::string::npos) << sentences_;
  // Torques of other friction: an arm of other values explains all.
  r = recorded("elbow-6r", 23);
  arm_ = plausible_model(*arm_, 23).arm;
  r.tau.col(1) += (8.0 * r.dq.col(1).array().sign()).matrix();
  EXPECT_EQ(findings(r), Names{"values:2"}) << sentences_;
}

// What the user said about the file is a mistake as any other: the options that replace it are named.
TEST_F(AMistakenRecording, ByAGivenOptionIsCorrectedByLeavingItOut) {
  const Recording r = recorded("elbow-6r", 26);
  const auto with = [](const std::map<std::string, std::string>& units, const std::map<std::string, std::string>& map = {}) {
    PreprocessingOptions options;
    options.signals.units = units;
    options.signals.map = map;
    return options;
  };
  EXPECT_EQ(findings(r, with({{"q", "deg"}})), Names{"given_unit:0"}) << sentences_;
  EXPECT_NE(sentences_.find("leaving out --units q=deg mends it"), std::string::npos) << sentences_;
  EXPECT_EQ(findings(r, with({{"dq", "deg/s"}, {"q", "deg"}})), Names{"given_unit:0"}) << sentences_;
  EXPECT_NE(sentences_.find("leaving out --units dq=deg/s,q=deg mends it"), std::string::npos) << sentences_;
  EXPECT_EQ(findings(r, with({}, {{"tau2", "tau3"}, {"tau3", "tau2"}})), Names{"swapped_joints:2"}) << sentences_;
  EXPECT_NE(sentences_.find("leaving out --map tau2=tau3,tau3=tau2 mends it"), std::string::npos) << sentences_;
  // A right option is kept beside what it lacks.
  Recording degrees = r;
  degrees.q *= 180.0 / M_PI;
  degrees.dq *= 180.0 / M_PI;
  degrees.tau.col(1) *= -1.0;
  EXPECT_EQ(findings(degrees, with({{"dq", "deg/s"}, {"q", "deg"}})), Names{"torque_sign:2"}) << sentences_;
  EXPECT_NE(sentences_.find("; --units q=deg,dq=deg/s,tau2=-Nm mends it"), std::string::npos) << sentences_;
  // The torque that is reversed twice is right.
  EXPECT_EQ(findings(r, with({{"tau2", "-Nm"}, {"tau3", "-Nm"}})), Names{"given_unit:0"}) << sentences_;
  EXPECT_NE(sentences_.find("; leaving out --units tau2=-Nm,tau3=-Nm mends it"), std::string::npos) << sentences_;
}

TEST_F(AMistakenRecording, WithOneWrongGainIsNamedWithTheFactor) {
  Recording r = recorded("elbow-6r", 24);
  r.tau.col(2) *= 1.7;
  EXPECT_EQ(findings(r), Names{"torque_unit:3"}) << sentences_;
  const std::string words = "fits with a factor of ";
  EXPECT_NEAR(std::stod(sentences_.substr(sentences_.find(words) + words.size())), 1.0 / 1.7, 0.02) << sentences_;
}

// If joints move as one, that is the only finding.
TEST_F(AMistakenRecording, OfJointsThatMoveAsOneHasThisFindingAlone) {
  Recording r = recorded("elbow-6r", 25);
  r.q.col(3) = 0.5 * r.q.col(1);
  r.dq.col(3) = 0.5 * r.dq.col(1);
  r.tau.col(2) *= -1.0;
  EXPECT_EQ(findings(r), Names{"not_compared:2"}) << sentences_;
  EXPECT_NE(sentences_.find("joints 2 and 4 move as one"), std::string::npos) << sentences_;
}

// Positions and velocities of one unit are both in degrees, or neither.
TEST(AUnit, OfVelocitiesFollowsFromTheTravelOfThePositions) {
  const Model arm = read_model("elbow-6r");
  MotionShape shape;
  shape.duration = 10.0;
  const Recording radians = synthetic_recording(plausible_model(arm, 3).arm, shape);
  const auto units = [&](double of_q, double of_dq) {
    Recording r = radians;
    r.q *= of_q;
    r.dq *= of_dq;
    QuickFit fit;
    fit.shares = VectorXd::Zero(6);
    Names out;
    for (const RecordingQuestion& q : questions_of(arm, r, {}, std::vector<bool>(6, true), fit)) {
      if (q.kind == QualityKind::kDegrees && !q.joint) out.push_back(q.units);
    }
    return out;
  };
  const double degrees = 180.0 / M_PI;
  EXPECT_EQ(units(1.0, 1.0), (Names{"q=deg,dq=deg/s"}));
  EXPECT_EQ(units(1.0, degrees), (Names{"q=deg,dq=deg/s", "dq=deg/s"}));
  EXPECT_EQ(units(degrees, 1.0), (Names{"q=deg,dq=deg/s", "q=deg"}));
}

// Each recording alone fits factors of its own, which would make one arm look like two.
TEST(AUnit, OfTorquesIsTheSameInAllRecordingsOfACommand) {
  const Model arm = read_model("elbow-6r"), plausible = plausible_model(arm, 41).arm;
  const VectorXd gains = (VectorXd(6) << 9.0, 10.0, 8.5, 3.0, 2.0, 2.5).finished();
  PreprocessingOptions options;
  MatrixXd rms(6, 2), mended = rms;
  for (const int k : {0, 1}) {
    MotionShape shape;
    shape.duration = 20.0;
    shape.rate = 100.0;
    shape.seed = static_cast<unsigned>(k + 41);
    auto r = std::make_shared<Recording>(synthetic_recording(plausible, shape));
    r->tau += noise_like(r->tau, 0.03, shape.seed);
    r->tau *= gains.cwiseInverse().asDiagonal();
    rms.col(k) = r->tau.colwise().norm();
    options.in_memory[k == 0 ? "one" : "two"] = r;
  }
  Identification fit;
  fit.train_error.relative = VectorXd::Ones(6);
  const MendedSetUp set_up = mended_set_up(arm, {"one", "two"}, {}, options, fit);
  ASSERT_EQ(set_up.recordings.size(), 2U);
  mended << set_up.recordings.at("one")->tau.colwise().norm().transpose(), set_up.recordings.at("two")->tau.colwise().norm().transpose();
  const Eigen::ArrayXXd factors = mended.array() / rms.array();
  EXPECT_LT((factors.col(0) / factors.col(1) - 1.0).abs().maxCoeff(), 1e-9) << factors;
}

// That a recording of a command is without a mistake follows from its own torques.
TEST(AMistake, OfSomeRecordingsIsDeniedForTheOthersOnlyIfTheyFitBetterWithoutIt) {
  const Model arm = read_model("elbow-6r"), plausible = plausible_model(arm, 43).arm;
  for (const bool all : {true, false}) {
    PreprocessingOptions options;
    for (const char* name : {"one", "two", "three"}) {
      MotionShape shape;
      shape.duration = 20.0;
      shape.rate = 100.0;
      shape.seed = static_cast<unsigned>(43 + options.in_memory.size());
      auto r = std::make_shared<Recording>(synthetic_recording(plausible, shape));
      r->tau += noise_like(r->tau, 0.03, shape.seed);
      if (all || *name != 'o') r->tau.col(1).swap(r->tau.col(2));
      options.in_memory[name] = r;
    }
    Identification fit;
    fit.train_error.relative = VectorXd::Ones(6);
    const MendedSetUp set_up = mended_set_up(arm, {"one", "two"}, {"three"}, options, fit);
    ASSERT_EQ(set_up.findings.size(), 1U);
    EXPECT_EQ(set_up.recordings.size(), all ? 3U : 2U);
    const std::string& sentence = set_up.findings[0].sentence;
    EXPECT_EQ(sentence.find("one does not have this mistake, and options count for all recordings: change two, three.") == std::string::npos, all) << sentence;
    EXPECT_EQ(sentence.find("does not have") == std::string::npos, all) << sentence;
  }
}

// Rows that cannot be right come before what does not fit the robot because of them.
TEST(MergedFindings, BeginWithRowsThatCannotBeRight) {
  QualityFinding jump, change;
  jump.kind = QualityKind::kJumps;
  change.kind = QualityKind::kChangedMidway;
  jump.severity = change.severity = Severity::kFault;
  EXPECT_EQ(merged_findings({change}, {jump}).front().kind, QualityKind::kJumps);
}

// Columns that hold no torques explain by themselves that the arm does not fit.
TEST(MergedFindings, OmitMismatchesThatAnUnusableColumnExplains) {
  const auto finding = [](QualityKind kind) {
    QualityFinding f;
    f.kind = kind;
    f.severity = Severity::kFault;
    return f;
  };
  for (const QualityKind own : {QualityKind::kZeroSignal, QualityKind::kSameColumn, QualityKind::kStaleRows}) {
    const std::vector<QualityFinding> merged = merged_findings({finding(QualityKind::kUnexplained), finding(QualityKind::kNoSign), finding(QualityKind::kBrakes)}, {finding(own)});
    EXPECT_EQ(merged.size(), own == QualityKind::kStaleRows ? 4U : 2U) << name_of(own);
  }
}

}  // namespace
}  // namespace veridyn
