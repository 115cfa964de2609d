#include "veridyn/identification/robot_check.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "identification/synthetic_recording.hpp"
#include "recordings/signals/units.hpp"
#include "veridyn/model/model_file.hpp"
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
      out.push_back(f.finding + ":" + std::to_string(f.joint));
      sentences_ += f.sentence + "\n";
    }
    return out;
  }

  std::string path_;
  std::optional<Model> arm_;
  std::string sentences_;
};

using Names = std::vector<std::string>;

TEST_F(AMistakenRecording, IsNotSeenInASoundOne) {
  for (const char* robot : {"psm-3dof", "elbow-6r", "scara"})
    EXPECT_EQ(findings(recorded(robot, 3)), Names{}) << robot << "\n" << sentences_;
}

// Standing still, moving one joint only, or too short: none of it tells signs or order.
TEST_F(AMistakenRecording, IsNotSeenWhereTheMotionDoesNotTell) {
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
TEST_F(AMistakenRecording, IsNamedWithTheShareThatFalls) {
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

TEST_F(AMistakenRecording, WithTorquesTurnedRoundIsMendedByUnits) {
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

TEST_F(AMistakenRecording, WithAllTorquesTurnedRoundIsSeenByItsFriction) {
  Recording r = recorded("psm-3dof", 5);
  r.tau *= -1.0;
  EXPECT_EQ(findings(r), (Names{"torque_sign:1", "torque_sign:2", "torque_sign:3"})) << sentences_;
}

TEST_F(AMistakenRecording, WithSwappedTorquesIsMendedByMap) {
  Recording r = recorded("elbow-6r", 6);
  r.tau.col(1).swap(r.tau.col(2));
  EXPECT_EQ(findings(r), Names{"swapped_joints:2"}) << sentences_;
  EXPECT_NE(sentences_.find("--map tau2=tau3,tau3=tau2 mends it"), std::string::npos) << sentences_;
  PreprocessingOptions mended;
  mended.signals.map = {{"tau2", "tau3"}, {"tau3", "tau2"}};
  EXPECT_EQ(findings(r, mended), Names{}) << sentences_;
}

TEST_F(AMistakenRecording, WithSwappedMotionIsMendedByMap) {
  Recording r = recorded("elbow-6r", 7);
  r.q.col(1).swap(r.q.col(2));
  r.dq.col(1).swap(r.dq.col(2));
  EXPECT_EQ(findings(r), Names{"swapped_joints:2"}) << sentences_;
  EXPECT_NE(sentences_.find("--map q2=q3,q3=q2,dq2=dq3,dq3=dq2 mends it"), std::string::npos) << sentences_;
}

TEST_F(AMistakenRecording, InDegreesIsMendedByUnits) {
  Recording r = recorded("elbow-6r", 8);
  r.q *= 180.0 / M_PI;
  r.dq *= 180.0 / M_PI;
  EXPECT_EQ(findings(r), Names{"degrees:0"}) << sentences_;
  EXPECT_NE(sentences_.find("--units q=deg,dq=deg/s mends it"), std::string::npos) << sentences_;
}

// Every position lies within its joint's limits, which in degrees it would leave.
TEST_F(AMistakenRecording, IsNotInDegreesWhereRadiansAreWithinTheLimits) {
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

TEST_F(AMistakenRecording, OfCurrentsIsSeenByAnArmWithValues) {
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
TEST_F(AMistakenRecording, OfCurrentsIsSeenByGainsThatDiffer) {
  Recording r = recorded("elbow-6r", 10);
  ModelDescription d = arm_->description();
  for (int i = 0; i < 6; ++i) {
    d.coordinates[i].drive_gain = 12.0 - i;
    r.tau.col(i) /= 12.0 - i;
  }
  arm_.emplace(Model(std::move(d)));
  EXPECT_EQ(findings(r), Names{"current:0"}) << sentences_;
}

}  // namespace
}  // namespace veridyn
