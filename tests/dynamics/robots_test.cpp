#include <gtest/gtest.h>

#include "support/energy.hpp"
#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/files/model_file.hpp"

// The robots in data/robots/, with random bodies: what a file says about masses is nobody's
// business here.

namespace veridyn {
namespace {

constexpr double kRounding = 1e-13;  // relative; both sides add some thousand products

class OnEveryRobotFile : public testing::TestWithParam<std::string> {
 protected:
  static Model robot() {
    ModelDescription description = read_model(GetParam()).description();
    Random random(101);
    for (Frame& frame : description.frames) {
      if (frame.body) frame.body->phi = random.body();
    }
    return Model(description);
  }

  Model arm_ = robot();
  std::vector<State> states_ = test_states(arm_.joints(), 102);
};
INSTANTIATE_TEST_SUITE_P(Robot, OnEveryRobotFile, testing::ValuesIn(robot_names()),
                         sample_arm_name);

TEST(RobotFiles, AtLeastOneIsFound) {
  EXPECT_FALSE(robot_names().empty());
}

TEST_P(OnEveryRobotFile, InverseDynamicsAreLagrangesEquations) {
  for (const State& s : states_) {
    const VectorXd tau = inverse_dynamics(arm_, s.q, s.dq, s.ddq);
    EXPECT_TRUE(near(tau, torques_of_lagrange(arm_, s), kRounding * (10.0 + 10 * tau.norm())));
  }
}

TEST_P(OnEveryRobotFile, TorqueIsTheSumOfItsParts) {
  const VectorXd rest = VectorXd::Zero(arm_.joints());
  for (const State& s : states_) {
    const VectorXd g = inverse_dynamics(arm_, s.q, rest, rest);
    const VectorXd parts =
        mass_matrix(arm_, s.q) * s.ddq + coriolis_matrix(arm_, s.q, s.dq) * s.dq + g;
    const VectorXd tau = inverse_dynamics(arm_, s.q, s.dq, s.ddq);
    EXPECT_TRUE(near(tau, parts, kRounding * (10 + 10 * tau.norm())));
  }
}

TEST_P(OnEveryRobotFile, RegressorsOfOneAndOfManyStatesAgreeWithTheTorques) {
  const VectorXd phi = *arm_.inertial_values();
  const TorqueRegressor batch(arm_);
  std::vector<MatrixXd> Y;
  for (const State& s : states_) {
    const VectorXd tau = inverse_dynamics(arm_, s.q, s.dq, s.ddq);
    const double tolerance = kRounding * (10 + tau.norm());
    EXPECT_TRUE(near(torque_regressor(arm_, s.q, s.dq, s.ddq) * phi, tau, tolerance));
    batch.evaluate(s.q.transpose(), s.dq.transpose(), s.ddq.transpose(), Y);
    for (int i = 0; i < arm_.joints(); ++i) {
      double sum = 0.0;
      for (size_t c = 0; c < batch.columns({i}).size(); ++c)
        sum += Y[i](0, static_cast<int>(c)) * phi[batch.columns({i})[c]];
      EXPECT_NEAR(sum, tau[i], tolerance);
    }
  }
}

}  // namespace
}  // namespace veridyn
