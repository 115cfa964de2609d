#include <gtest/gtest.h>

#include <cmath>

#include "control/arm_rig.hpp"
#include "control/control_support.hpp"
#include "veridyn/control/computed_torque.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/momentum_observer.hpp"
#include "veridyn/control/torque_uncertainty.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "kinematics/standard_motion.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plant.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn {
namespace {

// Without friction and with the true model r follows an outer torque as a first-order lag does, on
// an arm that tumbles: r(t) = f (1 - exp(-bandwidth t)).
TEST(MomentumObserver, FollowsAnOuterTorqueAsAFirstOrderLag) {
  for (const char* name : {"spherical_RRP", "elbow_6R", "parallelogram", "coupled_wrist"}) {
    const Model& arm = sample_arms().at(name);
    const int n = arm.joints();
    const Tip tip{last_frame(arm)};
    ArmState state(arm, tip);
    MomentumObserverOptions options;
    options.bandwidth = 50.0;
    MomentumObserver observer(arm, tip, options);
    Plant plant(arm);
    Random random(6);
    const VectorXd q = random.vector(n, -1, 1);
    const VectorXd dq = random.vector(n, -0.5, 0.5);
    plant.set_state(q, dq);
    const VectorXd outer = random.vector(n, -2, 2);
    const VectorXd none = VectorXd::Zero(n);
    // Motors carry the weight, so that the arm does not fall too fast for the time step.
    const double dt = 1e-4;
    state.update(plant.q(), plant.dq());
    observer.update(state, none, none, dt);
    for (int k = 1; k <= 1500; ++k) {
      const VectorXd motors = state.bias();
      const VectorXd all = motors - outer;
      ASSERT_EQ(plant.step(all, dt), StepStatus::kOk);
      state.update(plant.q(), plant.dq());
      observer.update(state, motors, none, dt);
      if (k % 300 != 0) continue;
      const VectorXd expected = (1.0 - std::exp(-50.0 * dt * k)) * outer;
      EXPECT_TRUE(near(observer.torque(), expected, 0.02 * (1.0 + outer.norm()))) << name << k;
    }
  }
}

// After a fast motion the residual decays with the bandwidth, and the threshold no faster and no slower.
TEST(MomentumObserver, TheThresholdDecaysAtTheRateOfTheResidual) {
  const Model& arm = sample_arms().at("elbow_6R");
  const int n = arm.joints();
  const Tip tip{last_frame(arm)};
  ArmState state(arm, tip);
  state.update(VectorXd::Constant(n, 0.3), VectorXd::Zero(n));
  MomentumObserverOptions options;
  options.bandwidth = 40.0;
  MomentumObserver observer(arm, tip, options);
  TorqueUncertainty uncertainty(arm, options.uncertainty);
  const VectorXd none = VectorXd::Zero(n), fast = VectorXd::Constant(n, 20.0);
  const VectorXd at_rest = uncertainty.update(state, none), moving = uncertainty.update(state, fast);
  ASSERT_GT((moving - at_rest).minCoeff(), 0.0);
  const double dt = 1e-3;
  observer.update(state, state.bias(), fast, dt);
  EXPECT_TRUE(near(observer.threshold(), moving, 1e-12 * moving.norm()));
  for (int k = 0; k < 10; ++k) observer.update(state, state.bias(), none, dt);
  EXPECT_TRUE(near(observer.threshold(), at_rest + std::exp(-40.0 * 10 * dt) * (moving - at_rest), 1e-12 * moving.norm()));
}

// The threshold against its definition: every parameter wrong by its own share, one after the
// other, through inverse dynamics.
TEST(TorqueUncertainty, IsTheRootSumOfSquaresOfParameterContributions) {
  for (const char* name : {"spherical_RRP", "coupled_wrist", "branched_tree"}) {
    const Model& arm = sample_arms().at(name);
    const int n = arm.joints();
    ArmState state(arm, {last_frame(arm)});
    UncertaintyOptions options;
    options.relative = 0.07;
    options.deviations = 2.0;
    TorqueUncertainty uncertainty(arm, options);
    EXPECT_FALSE(uncertainty.identified());
    const State s = test_states(n, 31).back();
    state.update(s.q, s.dq);
    const VectorXd phi = *arm.inertial_values();
    VectorXd sum = VectorXd::Zero(n);
    VectorXd tau(n);
    for (Eigen::Index p = 0; p < phi.size(); ++p) {
      VectorXd wrong = VectorXd::Zero(phi.size());
      wrong[p] = 0.07 * phi[p];
      RigidBodyDynamics(arm, wrong).inverse_dynamics(s.q, s.dq, s.ddq, tau);
      sum += tau.cwiseAbs2();
    }
    EXPECT_TRUE(near(uncertainty.update(state, s.ddq), 2.0 * sum.cwiseSqrt(), 1e-9));
  }
}

// An identified model is asked for its covariance, and for the error that it leaves.
TEST(TorqueUncertainty, RequiresTheCovarianceOfAnIdentifiedModel) {
  ModelDescription description = sample_arms().at("planar_2R").description();
  const std::string body = description.frames[1].name;
  IdentifiedBase base;
  base.clusters = 4;
  IdentifiedParameter first{"hx_" + body, "kg m", {}, 1.0, 1.0, Eigen::Vector3d(0.1, 0.2, 0)};
  IdentifiedParameter second{"Lzz_" + body, "kg m^2", {}, 1.0, 1.0, Eigen::Vector3d(0.05, 0, 0.1)};
  base.parameters = {first, second};
  base.error = Eigen::Vector2d(0.1, 0.0);
  description.identified = base;
  const Model arm(std::move(description));
  TorqueUncertainty uncertainty(arm);
  EXPECT_TRUE(uncertainty.identified());
  ArmState state(arm, {last_frame(arm)});
  const State s = test_states(2, 32).back();
  state.update(s.q, s.dq);
  const MatrixXd Y = torque_regressor(arm, s.q, s.dq, s.ddq);
  // Rms torque in the standard motion: no friction on this arm.
  const MotionSamples motion = standard_motion(arm);
  VectorXd squares = VectorXd::Zero(2);
  for (Eigen::Index k = 0; k < motion.rows(); ++k) {
    const VectorXd q = motion.q.row(k).transpose();
    const VectorXd dq = motion.dq.row(k).transpose();
    const VectorXd ddq = motion.ddq.row(k).transpose();
    squares += inverse_dynamics(arm, q, dq, ddq).cwiseAbs2();
  }
  const VectorXd rms = (squares / static_cast<double>(motion.rows())).cwiseSqrt();
  const VectorXd& u = uncertainty.update(state, s.ddq);
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector3d YF = Y(i, 11) * first.scatter + Y(i, 19) * second.scatter;
    const double left = base.error[i] * rms[i];
    EXPECT_NEAR(u[i], 3.0 * std::sqrt(YF.squaredNorm() + left * left), 1e-9);
  }
}

struct Touched {
  int false_alarms = 0;
  bool found = false;
  std::string frame;
  double force_error = 0.0;  // [N] at the end
};

// A tracked motion with a model that is wrong by 5 %; from 4 s on a force acts on `frame`.
Touched move_and_touch(const Model& real, const std::string& frame, const Eigen::Vector3d& force) {
  const Model model = with_wrong_parameters(real, 0.05, 9);
  ArmRig rig(real, {"tool"});
  TipKinematics touched(real, {frame});
  ArmState state(model, {"tool"});
  MomentumObserverOptions options;
  options.uncertainty.relative = 0.05;
  MomentumObserver observer(model, {"tool"}, options);
  FrictionCompensation friction(model);
  ComputedTorque control(3, {Eigen::Vector3d(100, 100, 200), Eigen::Vector3d(20, 20, 28)});
  JointReference wanted(3);
  const Eigen::Vector3d middle(0.1, 0.05, 0.12);
  const Eigen::Vector3d reach(0.5, 0.4, 0.05);
  rig.place(middle);
  Touched out;
  VectorXd motors = VectorXd::Zero(3);
  for (int k = 0; k < 5000; ++k) {
    const double t = kPeriod * k;
    const double in = std::min(1.0, t);
    const double w = 1.5;
    wanted.q = middle + in * reach * std::sin(w * t);
    wanted.dq = in * reach * w * std::cos(w * t);
    wanted.ddq = -in * reach * w * w * std::sin(w * t);
    state.update(rig.q(), rig.dq());
    const VectorXd& r = observer.update(state, motors, control.acceleration(), kPeriod);
    motors = control.update(state, wanted);
    motors += friction.update(state, wanted.dq, wanted.q - rig.q(), kPeriod);
    VectorXd all = motors;
    const bool pushes = k >= 4000;
    if (pushes) {
      touched.update(rig.engine().q(), rig.engine().dq());
      all -= touched.jacobian().topRows<3>().transpose() * force;
    }
    EXPECT_EQ(rig.cycle(all), StepStatus::kOk);
    if (!pushes && observer.contact()) ++out.false_alarms;
    if (pushes && observer.contact()) {
      out.found = true;
      out.frame = real.frames()[observer.frame()->value].name;
    }
    EXPECT_TRUE(r.allFinite());
  }
  out.force_error = (observer.force() - force).norm();
  return out;
}

TEST(MomentumObserver, FindsTheTouchedLinkWithoutFalseAlarms) {
  // Bodies balanced as on the real arm, so that the threshold is not all weight.
  const Model real = plausible_model(read_model("psm-3dof"), 3).arm;
  // On the tool along the shaft's side and axis: all three joints notice.
  const Touched tool = move_and_touch(real, "tool", {18, 10, 25});
  EXPECT_EQ(tool.false_alarms, 0);
  EXPECT_TRUE(tool.found);
  EXPECT_EQ(tool.frame, "tool");
  // On the elbow the insertion notices nothing.
  const Touched elbow = move_and_touch(real, "elbow", {25, 25, 10});
  EXPECT_EQ(elbow.false_alarms, 0);
  EXPECT_TRUE(elbow.found);
  EXPECT_EQ(elbow.frame, "upper");  // the first body that pitch moves, or further out
  const Touched nothing = move_and_touch(real, "tool", {0, 0, 0});
  EXPECT_FALSE(nothing.found);
  EXPECT_EQ(nothing.false_alarms, 0);
}

TEST(MomentumObserver, InvalidOptionsAreRefused) {
  const Model& arm = sample_arms().at("planar_2R");
  MomentumObserverOptions options;
  options.bandwidth = 0.0;
  EXPECT_THROW(MomentumObserver(arm, {last_frame(arm)}, options), InvalidInput);
  UncertaintyOptions uncertainty;
  uncertainty.relative = 0.0;
  EXPECT_THROW(TorqueUncertainty(arm, uncertainty), InvalidInput);
}

// At rest the whole level of friction is unknown: that of this position and of this load.
TEST(TorqueUncertainty, FrictionIsEvaluatedAtThePositionAndTheLoad) {
  const Model bare = plausible_model(read_model("psm-3dof"), 1).arm;
  const auto with = [&bare](const std::vector<EffectTerm>& effects) {
    std::vector<EffectTerm> all = {effect_on(bare, "coulomb_friction", 2, {{"level", 1.0}})};
    all.insert(all.end(), effects.begin(), effects.end());
    return with_effects(bare, all);
  };
  const Model plain = with({});
  const Model by_position =
      with({effect_on(bare, "position_dependent_friction", 2, {{"slope", 10.0}, {"curvature", 0.0}})});
  const Model by_load = with({effect_on(bare, "load_dependent_friction", 2, {{"coefficient", 0.2}})});
  const VectorXd none = VectorXd::Zero(3);
  ArmState state(plain, {"tool"});
  TorqueUncertainty level(plain);
  TorqueUncertainty on_the_way(by_position);
  TorqueUncertainty under_load(by_load);
  for (const double insertion : {0.05, 0.15}) {
    state.update(Eigen::Vector3d(0.1, 0.4, insertion), none);
    const double without = level.update(state, none)[2];
    EXPECT_NEAR(on_the_way.update(state, none)[2] - without, 10.0 * insertion, 1e-9);
    EXPECT_NEAR(under_load.update(state, none)[2] - without, 0.2 * std::abs(state.rigid_bias()[2]), 1e-9);
    EXPECT_GT(std::abs(state.rigid_bias()[2]), 0.1);
  }
}

}  // namespace
}  // namespace veridyn
