#include <gtest/gtest.h>

#include "control/control_support.hpp"
#include "veridyn/control/impedance.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/simulation/plant.hpp"

namespace veridyn {
namespace {

Eigen::Matrix3d some_rotation(unsigned seed) {
  return rotation_of(Random(seed).vector(3, -1.2, 1.2));
}

TEST(AnalyticalTask, RollPitchYawInvertsTheRotationMatrix) {
  Random random(5);
  for (int k = 0; k < 50; ++k) {
    const Eigen::Vector3d angles(random.in(-3.1, 3.1), random.in(-1.5, 1.5), random.in(-3.1, 3.1));
    const Eigen::Matrix3d R = rotation_of(angles);
    EXPECT_TRUE((R * R.transpose()).isIdentity(1e-12));
    EXPECT_TRUE(near(roll_pitch_yaw(R), angles, 1e-12));
  }
  const Eigen::Matrix3d up = rotation_of({0.3, M_PI / 2, 0.7});
  EXPECT_TRUE(near(rotation_of(roll_pitch_yaw(up)), up, 1e-7));
}

// J_a and its rate against central differences of x and dx; power is the same in both coordinates.
TEST(AnalyticalTask, JacobianAndItsRateMatchDifferencesAndPowerIsInvariant) {
  const Model arm = sample_arms().at("elbow_6R");
  TipKinematics tip(arm, {last_frame(arm), {0.02, 0.1, 0.05}});
  for (unsigned seed = 1; seed < 6; ++seed) {
    Random random(seed);
    const VectorXd q = random.vector(6, -1.2, 1.2);
    const VectorXd dq = random.vector(6, -1, 1);
    tip.update(q, dq);
    // A home within 70 degrees, so that no angle is near its singular place.
    const Eigen::Matrix3d home = tip.rotation() * rotation_of(random.vector(3, -0.7, 0.7));
    AnalyticalTask task(6, TaskRows::kPose, home);
    task.update(tip);
    const Vector6d dx = task.dx();
    const MatrixXd J = task.jacobian();
    const MatrixXd dJ = task.jacobian_rate();
    EXPECT_TRUE(near(J * dq, dx, 1e-12));
    EXPECT_TRUE(near(task.T_A() * J, tip.jacobian(), 1e-12));
    const Vector6d h = random.vector(6, -5, 5);
    EXPECT_NEAR(task.wrench(h).dot(dx), h.dot(tip.twist()), 1e-12);

    const double step = 1e-5;
    const auto at = [&](double t) {
      const VectorXd moved = q + t * dq;
      tip.update(moved, dq);
      task.update(tip);
    };
    at(step);
    const Vector6d x_ahead = task.x();
    const MatrixXd J_ahead = task.jacobian();
    at(-step);
    EXPECT_TRUE(near(dx, (x_ahead - task.x()) / (2 * step), 1e-7));
    EXPECT_TRUE(near(dJ, (J_ahead - task.jacobian()) / (2 * step), 1e-7 * (1.0 + dJ.norm())));
  }
}

TEST(AnalyticalTask, NearItsSingularityRatesStayBounded) {
  const Model arm = sample_arms().at("elbow_6R");
  TipKinematics tip(arm, {last_frame(arm)});
  const VectorXd q = Random(3).vector(6, -1, 1);
  tip.update(q, VectorXd::Ones(6));
  AnalyticalTask task(6, TaskRows::kPose,
                      tip.rotation() * rotation_of({0.0, M_PI / 2, 0.0}).transpose());
  task.update(tip);
  EXPECT_TRUE(task.jacobian_rate().allFinite());
  EXPECT_LT(task.jacobian().norm(), 1e2);
}

struct Case {
  std::string arm;
  TaskRows rows;
};

class ImpedanceOn : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Arms, ImpedanceOn,
                         testing::Values(Case{"spherical_RRP", TaskRows::kPosition},
                                         Case{"parallelogram", TaskRows::kPosition},
                                         Case{"elbow_6R", TaskRows::kPosition},
                                         Case{"elbow_6R", TaskRows::kPose},
                                         Case{"serial_RRPRRPR", TaskRows::kPose}),
                         [](const testing::TestParamInfo<Case>& of) {
                           return of.param.arm +
                                  (of.param.rows == TaskRows::kPose ? "_pose" : "_position");
                         });

// Thesis (7.9): the tip obeys M_d (ddx_d - ddx) + K_d (dx_d - dx) + K_p (x_d - x) = h_a. The plant
// takes the torques and the wrench; ddx is the second difference of x along its motion.
TEST_P(ImpedanceOn, TheTipObeysTheImpedanceEquation) {
  const Model& arm = sample_arms().at(GetParam().arm);
  const int n = arm.joints();
  const int rows = static_cast<int>(GetParam().rows);
  const Tip tip{last_frame(arm), {0.01, 0.05, 0.1}};
  ArmState state(arm, tip);
  Plant plant(arm);
  ImpedanceGains gains;
  gains.mass << 0.35, 0.36, 0.3, 0.02, 0.03, 0.04;
  gains.damping << 3, 4, 5, 0.1, 0.2, 0.3;
  gains.stiffness << 15, 20, 25, 1, 2, 3;
  int tried = 0;
  for (unsigned seed = 1; seed < 12; ++seed) {
    Random random(seed);
    const VectorXd q = random.vector(n, -1, 1);
    const VectorXd dq = random.vector(n, -0.5, 0.5);
    state.update(q, dq);
    ImpedanceOptions options;
    options.rows = GetParam().rows;
    options.home = state.tip().rotation() * some_rotation(seed);
    options.posture = VectorXd::Zero(n);
    Impedance control(arm, tip, gains, options);
    TaskReference wanted;
    wanted.x = Vector6d(random.vector(6, -0.3, 0.3));
    wanted.dx = Vector6d(random.vector(6, -0.1, 0.1));
    wanted.ddx = Vector6d(random.vector(6, -0.2, 0.2));
    Vector6d h = random.vector(6, -4, 4);
    const VectorXd tau = control.update(state, wanted, h) - state.tip().jacobian().transpose() * h;
    if (control.inverse().near_singular()) continue;
    ++tried;

    plant.set_state(q, dq);
    VectorXd ddq(n);
    ASSERT_EQ(plant.accelerate(tau, ddq), StepStatus::kOk);
    AnalyticalTask task(n, options.rows, options.home);
    TipKinematics kinematics(arm, tip);
    const double t = 3e-4;
    const auto x = [&](double at) {
      const VectorXd moved = q + at * dq + 0.5 * at * at * ddq;
      kinematics.update(moved, dq);
      task.update(kinematics);
      return task.x();
    };
    const Vector6d here = x(0.0);
    const Vector6d ddx = (x(t) - 2.0 * here + x(-t)) / (t * t);
    const Vector6d dx = (x(t) - x(-t)) / (2.0 * t);
    x(0.0);
    const Vector6d law = gains.mass.cwiseProduct(wanted.ddx - ddx) +
                         gains.damping.cwiseProduct(wanted.dx - dx) +
                         gains.stiffness.cwiseProduct(task.difference(wanted.x));
    const Vector6d h_a = task.wrench(h);
    EXPECT_TRUE(near(law.head(rows), h_a.head(rows), 3e-4 * (1.0 + ddx.norm() + ddq.norm())));
  }
  EXPECT_GE(tried, 3);
}

TEST(Impedance, InvalidGainsAreRefused) {
  const Model& arm = sample_arms().at("spherical_RRP");
  ImpedanceGains gains;
  gains.mass[1] = 0.0;
  EXPECT_THROW(Impedance(arm, {last_frame(arm)}, gains), InvalidInput);
  gains.mass[1] = 1.0;
  Impedance control(arm, {last_frame(arm)}, gains);
  gains.damping[2] = NAN;
  EXPECT_FALSE(control.set_gains(gains));
  EXPECT_TRUE(control.gains().damping.allFinite());
  ImpedanceOptions options;
  options.posture = VectorXd::Zero(2);
  EXPECT_THROW(Impedance(arm, {last_frame(arm)}, {}, options), InvalidInput);
  options.posture.resize(0);
  options.home *= 2.0;
  EXPECT_THROW(Impedance(arm, {last_frame(arm)}, {}, options), InvalidInput);
}

}  // namespace
}  // namespace veridyn
