#include "dvrk/arms/gravity_chain.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>

#include "dvrk/gravity_support.hpp"
#include "support/near.hpp"
#include "dvrk/arms/effort_scales.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "support/refusal.hpp"

namespace veridyn::dvrk {
namespace {

// An endoscope arm with a body on each link.
Model ecm_with_bodies(unsigned seed) {
  ModelDescription description = arm_model(read_arm("ECM")).description();
  for (Frame& frame : description.frames)
    if (frame.name != "tip") frame.body = Body{};
  return with_random_bodies(Model(description), seed);
}

struct Case {
  std::string robot;
  std::string arm;
};

class OnEveryArm : public testing::TestWithParam<Case> {
 protected:
  Model model(unsigned seed) const {
    return GetParam().robot == "ecm" ? ecm_with_bodies(seed)
                                     : with_random_bodies(read_model(GetParam().robot), seed);
  }
};

// The written file against the model: energy of the rows, differentiated, is the model's gravity
// torque, for random bodies on parallelogram, counterweight and all.
TEST_P(OnEveryArm, GravityOfTheFileEqualsThatOfTheModel) {
  const ArmFacts arm = read_arm(GetParam().arm);
  for (const unsigned seed : {1U, 2U, 3U}) {
    const Model robot = model(seed);
    const GravityChain chain = fit_gravity_chain(robot, arm);
    const auto file = nlohmann::json::parse(to_gravity_json(chain, robot.name()));
    EXPECT_EQ(file.at("DH").at("joints").size(), static_cast<std::size_t>(arm.kinematic_joints()));
    Random random(10 + seed);
    for (int trial = 0; trial < 20; ++trial) {
      std::vector<double> q;
      VectorXd q_model = VectorXd::Zero(robot.joints());
      for (const GravityRow& row : chain.rows) {
        q.push_back(row.prismatic ? random.in(0.0, 0.24) : random.in(-1.5, 1.5));
        if (const auto i = robot.find_coordinate(row.joint)) q_model[i->value] = q.back();
      }
      const VectorXd rest = VectorXd::Zero(robot.joints());
      const VectorXd tau = inverse_dynamics(robot, q_model, rest, rest);
      for (std::size_t k = 0; k < q.size(); ++k) {
        const auto i = robot.find_coordinate(chain.rows[k].joint);
        if (!i) continue;
        EXPECT_NEAR(gravity_by_differences(file, q, k, 9.81), tau[i->value], 1e-7 * (1.0 + tau.norm()))
            << chain.rows[k].joint;
      }
    }
    EXPECT_LT((chain.largest_error.array() / chain.largest_torque.array().max(1e-9)).maxCoeff(),
              1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, OnEveryArm,
                         testing::Values(Case{"psm-3dof", "PSM1"}, Case{"psm-wrist", "PSM2"},
                                         Case{"ecm", "ECM"}),
                         [](const auto& c) { return c.param.arm; });

// Centres stay where a laboratory can read them, also where a mass could be anything.
TEST(GravityChain, CentresAreNearTheirLinks) {
  const GravityChain chain =
      fit_gravity_chain(with_random_bodies(read_model("psm-wrist"), 6), read_arm("PSM1"));
  for (const GravityRow& row : chain.rows) EXPECT_LE(row.com.norm(), 0.1 + 1e-9) << row.joint;
}

// A counterweight that slides a little askew: no serial chain has that gravity, and the error that
// is stated is the true one, within the limits of the model where these are narrower than the arm's.
TEST(GravityChain, TheStatedErrorOfABranchedArmIsTheTrueOne) {
  for (const double share : {1.0, 0.2}) {
    ModelDescription description = with_random_bodies(read_model("psm-3dof"), 7).description();
    for (Frame& frame : description.frames)
      if (frame.name == "counterweight_rail") frame.variable.offset += 0.005;
    for (Coordinate& c : description.coordinates) c.limits.upper = c.limits.lower + share * (c.limits.upper - c.limits.lower);
    const Model askew(description);
    const GravityChain chain = fit_gravity_chain(askew, read_arm("PSM1"));
    Random random(8);
    VectorXd largest = VectorXd::Zero(3);
    VectorXd largest_torque = VectorXd::Zero(3);
    const VectorXd rest = VectorXd::Zero(3);
    for (int trial = 0; trial < 2000; ++trial) {
      VectorXd q = VectorXd::Zero(6);
      for (int k = 0; k < 3; ++k) {
        const Limits& limits = askew.coordinates()[k].limits;
        q[k] = random.in(limits.lower, limits.upper);
      }
      const VectorXd tau = inverse_dynamics(askew, q.head<3>(), rest, rest);
      largest = largest.cwiseMax((gravity_torques(chain, q).head<3>() - tau).cwiseAbs());
      largest_torque = largest_torque.cwiseMax(tau.cwiseAbs());
    }
    EXPECT_GT(largest.maxCoeff(), 1e-6);
    for (int k = 0; k < 3; ++k) {
      EXPECT_LT(largest[k], 1.3 * chain.largest_error[k] + 1e-9);
      EXPECT_GT(largest[k], 0.7 * chain.largest_error[k] - 1e-9);
      EXPECT_NEAR(largest_torque[k], chain.largest_torque[k], 0.1 * largest_torque[k]);
    }
  }
}

TEST(GravityChain, UnrepresentableModelsAreRefused) {
  const ArmFacts psm = read_arm("PSM1");
  const auto message_of = [](const Model& model, const ArmFacts& arm) -> std::string {
    return refusal([&] { fit_gravity_chain(model, arm); });
  };
  EXPECT_NE(message_of(read_model("psm-3dof"), psm).find("without values"), std::string::npos);
  EXPECT_NE(message_of(with_random_bodies(read_model("ur10e"), 1), psm).find("no coordinate"),
            std::string::npos);
  EXPECT_NE(message_of(with_random_bodies(read_model("mtm"), 1), read_arm("MTML"))
                .find("expected a PSM or ECM"),
            std::string::npos);
  ModelDescription tilted = with_random_bodies(read_model("psm-3dof"), 1).description();
  tilted.gravity = {1.0, 0.0, -9.7};
  EXPECT_NE(message_of(Model(tilted), psm).find("along -z"), std::string::npos);
  // With the thesis's printed constants, whose parallelogram does not close.
  EXPECT_NE(message_of(with_random_bodies(read_model("psm-3dof-printed"), 7), psm)
                .find("expected at most 5 %"),
            std::string::npos);
}

// If the limits of model and arm do not overlap, those of the arm are used.
TEST(GravityChain, LimitsOfTheArmAreUsedIfThoseOfTheModelAreDisjoint) {
  const auto fitted = [](double lower, double upper) {
    ModelDescription description = with_random_bodies(read_model("psm-3dof"), 9).description();
    for (Coordinate& c : description.coordinates) {
      if (c.name != "insertion") continue;
      c.limits.lower = lower;
      c.limits.upper = upper;
    }
    return fit_gravity_chain(Model(description), read_arm("PSM1"));
  };
  const double infinity = std::numeric_limits<double>::infinity();
  const GravityChain free = fitted(-infinity, infinity);
  const GravityChain apart = fitted(0.5, 0.7);
  const GravityChain narrow = fitted(0.0, 0.1);
  EXPECT_EQ(apart.largest_torque, free.largest_torque);
  EXPECT_GT((narrow.largest_torque - free.largest_torque).norm(), 1e-3);
}

// Effects that hold the arm besides gravity are named; a spring of unknown stiffness, and friction that rests, are not.
TEST(GravityChain, HoldingEffectsBesideGravityAreListed) {
  ModelDescription description = with_random_bodies(read_model("psm-3dof"), 10).description();
  description.effects.clear();
  const auto add = [&](const char* name, int joint, std::map<std::string, double> values) {
    EffectTerm term;
    term.effect = name;
    term.axis.coefficients = VectorXd::Unit(static_cast<Eigen::Index>(description.coordinates.size()), joint);
    term.values = std::move(values);
    description.effects.push_back(term);
  };
  add("joint_spring", 1, {{"stiffness", 2.0}});
  add("joint_spring", 0, {});
  add("viscous_friction", 0, {{"coefficient", 0.5}});
  const GravityChain chain = fit_gravity_chain(Model(description), read_arm("PSM1"));
  EXPECT_EQ(chain.left_out, std::vector<std::string>{"joint_spring(pitch)"});
  const auto file = nlohmann::json::parse(to_gravity_json(chain, "a \xff name"));
  EXPECT_EQ(file.at("veridyn").at("not_in_the_rows"), nlohmann::json::array({"joint_spring(pitch)"}));
  EXPECT_EQ(file.at("veridyn").at("arm"), "PSM1");
  EXPECT_EQ(file.at("veridyn").at("gravity_torques").at("pitch").at("largest_torque"), chain.largest_torque[1]);
}

TEST(GravityChain, AJointVectorOfTheWrongLengthIsRefused) {
  const GravityChain chain = fit_gravity_chain(with_random_bodies(read_model("psm-3dof"), 11), read_arm("PSM1"));
  EXPECT_TRUE(refuses_with("q has 3 entries, expected 6", [&] { gravity_torques(chain, VectorXd::Zero(3)); }));
}

class StaticFile : public testing::Test {
 protected:
  ~StaticFile() override { std::filesystem::remove(path_); }
  const std::string& write(const std::string& content) const {
    std::ofstream(path_) << content;
    return path_;
  }
  std::string path_ = (std::filesystem::temp_directory_path() /
                       ("veridyn_static_" + std::to_string(::getpid()) + ".csv"))
                          .string();
};

TEST_F(StaticFile, IsReadWithOrWithoutAHeader) {
  const StaticTorques plain = read_static_torques(write("0.1,0.2,1,2\n0.3,0.4,3,4\n"));
  const StaticTorques named =
      read_static_torques(write("# rest\npose,tau2,tau1,q1,q2\n7,2,1,0.1,0.2\n8,4,3,0.3,0.4\n"));
  for (const StaticTorques& s : {plain, named}) {
    ASSERT_EQ(s.q.rows(), 2);
    EXPECT_EQ(s.q(1, 1), 0.4);
    EXPECT_EQ(s.tau(0, 1), 2.0);
    EXPECT_EQ(s.tau(1, 0), 3.0);
  }
}

TEST_F(StaticFile, AnInvalidFileIsRefusedWithItsLine) {
  const auto message_of = [&](const std::string& content) -> std::string {
    return refusal([&] { read_static_torques(write(content)); });
  };
  EXPECT_NE(message_of("1,2,3\n").find(":1: found 3 columns"), std::string::npos);
  EXPECT_NE(message_of("q1,tau1\n1,2\n1,x\n").find(":3: found 'x'"), std::string::npos);
  EXPECT_NE(message_of("q1,tau1\n1,2\n1\n").find(":3: found 1 fields"), std::string::npos);
  EXPECT_NE(message_of("q1,q2,tau1\n1,2,3\n").find("q1..qn and tau1..taun"), std::string::npos);
  EXPECT_NE(message_of("q1,tau1\n").find("no rows"), std::string::npos);
  EXPECT_NE(message_of("1,2\n1,inf\n").find(":2: found 'inf', expected a finite number"), std::string::npos);
  EXPECT_NE(message_of("q1,tau1\n1,\n").find(":2: found ''"), std::string::npos);
  EXPECT_NE(message_of("q1,q3,tau1,tau3\n1,2,3,4\n").find("q1..qn and tau1..taun"), std::string::npos);
  EXPECT_NE(message_of("q1,q2,tau1,tau3\n1,2,3,4\n").find("q1..qn and tau1..taun"), std::string::npos);
  EXPECT_NE(message_of("q0,tau0\n1,2\n").find("q1..qn and tau1..taun"), std::string::npos);
  EXPECT_NE(message_of("q1x,tau1\n1,2\n").find("q1..qn and tau1..taun"), std::string::npos);
  EXPECT_NE(message_of("q,tau\n1,2\n").find("q1..qn and tau1..taun"), std::string::npos);
  EXPECT_NE(message_of("tau1,q1,tau1\n1,2,3\n").find("the column 'tau1' twice"), std::string::npos);
  EXPECT_NE(message_of("q1,tau1,q1\n1,2,3\n").find(":1: found the column 'q1' twice"), std::string::npos);
  EXPECT_NE(message_of("q1,tau1,tau1\n1,2,3\n").find(":1: found the column 'tau1' twice"), std::string::npos);
}

// Reported torque = current / configured scale. The truth is smaller by the gain, so the same
// current stands for less torque: more amperes per newton metre.
TEST(EffortScales, CorrectionsTurnReportedIntoTrueTorque) {
  ModelDescription description = read_model("psm-3dof").description();
  description.coordinates[0].recorded.torque_gain = 1.1;
  description.coordinates[1].drive_gain = 2.0;
  description.coordinates[1].drive_gain_deviation = 0.02;
  const ArmFacts arm = read_arm("PSM1");
  const RobotConfig robot = nominal_config(arm).robots[0];
  const std::vector<EffortScale> scales = corrected_scales(Model(description), arm, robot);
  ASSERT_EQ(scales.size(), 7U);
  const double current = 0.5;
  const double reported = current / robot.actuators[0].effort_to_amps;
  EXPECT_NEAR(current / scales[0].scale, reported / 1.1, 1e-12);
  EXPECT_NEAR(scales[1].scale, 0.5, 1e-15);
  EXPECT_NEAR(scales[1].std_scale, 0.005, 1e-15);  // 1 % of the gain is 1 % of the scale
  EXPECT_EQ(scales[2].scale, robot.actuators[2].effort_to_amps);
  EXPECT_TRUE(scales[2].source.empty());
  EXPECT_EQ(scales[2].unit, "A/N");
  EXPECT_TRUE(scales[4].source.empty());
  const auto file = nlohmann::json::parse(to_scales_json("PSM1", scales));
  const auto& actuators = file.at("robots").at(0).at("actuators");
  EXPECT_EQ(actuators.at(1).at("drive").at("effort_to_current").at("scale"), 0.5);
  EXPECT_EQ(actuators.at(2).at("veridyn").at("source"), "unchanged");
  RobotConfig short_one = robot;
  short_one.actuators.pop_back();
  EXPECT_THROW(corrected_scales(Model(description), arm, short_one), InvalidInput);
}

}  // namespace
}  // namespace veridyn::dvrk
