#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <tuple>

#include "control/psm_like.hpp"
#include "support/near.hpp"
#include "veridyn/control/adaptive_friction.hpp"
#include "veridyn/control/force_law.hpp"
#include "veridyn/control/model_error_observer.hpp"
#include "veridyn/control/momentum_observer.hpp"
#include "veridyn/control/object_impedance.hpp"
#include "veridyn/control/teleoperation.hpp"
#include "veridyn/control/tether_guard.hpp"
#include "veridyn/control/velocity_observer.hpp"

// A control loop meets numbers that are none. What comes out stays finite in that cycle, and the next
// good cycle is as good as ever.

namespace veridyn {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
const double kNoTimes[] = {kNan, kInf, -kInf, -1e-3, -1e4};

TEST(BadNumbers, AVelocityObserverIgnoresInvalidTimes) {
  for (const double bad : {kNan, kInf, -kInf, -1e-3, 0.0}) {
    VelocityObserver observer(1), undisturbed(1);
    const VectorXd none = VectorXd::Zero(1);
    for (int k = 0; k < 200; ++k) {
      const VectorXd q = VectorXd::Constant(1, 0.3e-3 * k);
      if (k == 100) observer.update(q, none, bad);
      EXPECT_EQ(observer.update(q, none, 1e-3), undisturbed.update(q, none, 1e-3)) << bad << k;
    }
    EXPECT_NEAR(observer.dq()[0], 0.3, 1e-6) << bad;
  }
}

// Each input alone: the residual starts afresh and finds the same as before.
TEST(BadNumbers, AMomentumObserverRestartsAfterANonFiniteCycle) {
  const Model arm = psm_like();
  const VectorXd none = VectorXd::Zero(3), bad = Eigen::Vector3d(0.0, kNan, 0.0);
  const VectorXd q = Eigen::Vector3d(0.1, 0.2, 0.1), push = Eigen::Vector3d(1.0, -2.0, 3.0);
  for (int lost = 0; lost < 9; ++lost) {
    ArmState state(arm, {"tool"});
    MomentumObserver touch(arm, {"tool"});
    const auto cycles = [&](int count) {
      for (int k = 0; k < count; ++k) {
        state.update(q, none);
        touch.update(state, state.bias() + push, none, 1e-3);
      }
    };
    cycles(500);
    const VectorXd found = touch.torque(), threshold = touch.threshold();
    EXPECT_TRUE(near(found, push, 1e-3));
    state.update(lost == 0 ? bad : q, lost == 1 ? bad : none);
    const double dt = lost < 4 ? 1e-3 : kNoTimes[lost - 4];
    touch.update(state, lost == 2 ? bad : state.bias(), lost == 3 ? bad : none, dt);
    EXPECT_EQ(touch.torque(), none) << lost;
    EXPECT_FALSE(touch.contact()) << lost;
    cycles(501);
    EXPECT_TRUE(near(touch.torque(), found, 1e-3)) << lost;
    EXPECT_TRUE(near(touch.threshold(), threshold, 1e-9)) << lost;
  }
}

TEST(BadNumbers, AModelErrorObserverKeepsItsEstimateAtInvalidTimes) {
  const Model arm = psm_like();
  const VectorXd y = Eigen::Vector3d(0.1, -0.1, 0.1);
  for (const double bad : kNoTimes) {
    ArmState state(arm, {"tool"});
    state.update(Eigen::Vector3d(0.1, 0.2, 0.1), VectorXd::Zero(3));
    ModelErrorObserver error(3, {10.0, VectorXd::Ones(3)});
    for (int k = 0; k < 10; ++k) error.update(state, y, 1e-3);
    const VectorXd known = error.torque();
    EXPECT_EQ(error.update(state, y, bad), known) << bad;
    EXPECT_EQ(error.update(state, y, 1e-3), known) << bad;  // the gap is not used
    EXPECT_GT((error.update(state, y, 1e-3) - known).norm(), 0.0) << bad;
  }
}

// An encoder without a sample: q is no number, and the velocity is extrapolated. What is learned
// afterwards is the same.
TEST(BadNumbers, AdaptiveFrictionContinuesAfterANonFiniteCycle) {
  const Model arm = psm_like();
  const VectorXd none = VectorXd::Zero(3);
  AdaptiveFrictionOptions options;
  options.enabled = true;
  const auto share = [&](int lost) {
    ArmState state(arm, {"tool"});
    FrictionCompensation friction(arm);
    AdaptiveFriction adaptive(friction, options);
    for (int k = 0; k < 8000; ++k) {
      const double phase = 2e-3 * k;
      const bool now = k == 1000 || k == 5000;
      const VectorXd q = Eigen::Vector3d(0.1, 0.2, 0.1) + 0.05 * std::sin(phase) * VectorXd::Ones(3);
      const VectorXd dq = 0.1 * std::cos(phase) * VectorXd::Ones(3);
      state.update(now && lost == 0 ? VectorXd::Constant(3, kNan) : q,
                   now && lost == 1 ? VectorXd::Constant(3, kNan) : dq);
      friction.update(state, dq, none, 1e-3);
      const VectorXd missing = VectorXd::Constant(3, now && lost == 2 ? kNan : (dq[0] > 0.0 ? -0.05 : 0.05));
      adaptive.update(state, missing, now && lost == 3 ? kNan : 1e-3, friction);
    }
    return adaptive.share(0);
  };
  const double undisturbed = share(-1);
  EXPECT_GT(std::abs(undisturbed - FrictionOptions().share), 0.05);
  for (const int lost : {0, 1, 2, 3}) EXPECT_NEAR(share(lost), undisturbed, 1e-3) << lost;
}

TEST(BadNumbers, AForceTrackerKeepsItsCorrectionInANonFiniteCycle) {
  for (const int lost : {0, 1, 2, 3}) {
    const ForceLaw law = tuned_force_law(2000.0, 300.0, 30.0);
    ForceTracker tracker(law), undisturbed(law);
    ForceReading reading;
    for (long k = 0; k < 100; ++k) {
      reading.force = 1.0;
      reading.number = k;
      const double last = undisturbed.update(2.0, reading, 0.0, 1e-3);
      EXPECT_NEAR(tracker.update(2.0, reading, 0.0, 1e-3), last, 1e-15) << lost << k;
      if (k != 50) continue;
      if (lost == 1) reading.force = kNan;
      const double kept =
          tracker.update(lost == 0 ? kNan : 2.0, reading, lost == 2 ? kNan : 0.0, lost == 3 ? kNan : 0.0);
      EXPECT_EQ(kept, last) << lost;
      EXPECT_EQ(tracker.update_without_sensor(2.0, kNan), last) << lost;
    }
  }
}

struct Tether {
  TetherGuard guard{2, {{0, 1, 20000.0}}, {}};
  std::vector<char> healthy{1, 0};
  void learn() {
    for (int k = 0; k < 2000; ++k) guard.update_length(0, 0.1, 0.0);
  }
  double step(double x) {
    guard.update({guard.motion(0).position, Eigen::Vector3d(x, 0.0, 0.0)}, healthy, 5.0);
    return x - guard.motion(0).position.x();
  }
};

// The falling end of TetherGuard's own test, without its position now and then or at the start.
TEST(BadNumbers, ATetherGuardFollowsAFallingEndThroughNonFiniteCycles) {
  Tether tether;
  tether.guard.update_length(0, kNan, 1.0);
  tether.guard.update_length(0, 1.0, kInf);
  EXPECT_TRUE(std::isnan(tether.guard.free_length(0)));
  tether.learn();
  for (int k = 0; k < 300; ++k) {
    const double t = 1e-3 * k;
    const bool lost = k == 0 || k % 50 == 49;
    const double length = tether.step(lost ? kNan : 0.1 - 0.3 * t + 0.5 * 10.0 * t * t);
    ASSERT_TRUE(tether.guard.motion(0).position.allFinite());
    if (!lost) { EXPECT_LE(length, 0.1) << k; }
  }
  EXPECT_GT(tether.guard.motion(0).position.x(), 0.2);
  // Positions beyond what can be squared move nothing.
  tether.guard.reset();
  tether.learn();
  for (const double x : {1e200, -1e200, 1e308}) tether.step(x);
  EXPECT_TRUE(tether.guard.motion(0).position.allFinite());
}

// A fall that is over says nothing about the next one.
TEST(BadNumbers, AResetTetherGuardForgetsTheLastFall) {
  Tether tether;
  tether.learn();
  tether.healthy[0] = 0;  // so that it does not follow
  for (int k = 0; k < 300; ++k) tether.step(0.1 + 5.0 * 1e-6 * k * k);
  tether.healthy[0] = 1;
  tether.guard.reset();
  EXPECT_EQ(tether.guard.motion(0).position.x(), 0.0);
  tether.learn();
  for (int k = 0; k < 300; ++k) tether.step(0.1);
  EXPECT_LT(tether.guard.motion(0).position.norm(), 1e-9);
}

TEST(BadNumbers, TeleoperationReleasesOnNonFiniteInputAndReengagesWithoutAJump) {
  const Eigen::Vector3d none = Eigen::Vector3d::Zero(), bad(0.0, kNan, 0.0), leader(0.1, 0.2, 0.3);
  for (const int lost : {0, 1, 2}) {
    Teleoperation tele({}, none, none);
    tele.clutch(true);
    tele.update(none, none, none);
    for (int k = 0; k < 100; ++k) tele.update(1e-4 * k * leader, none, leader);
    const Eigen::Vector3d here = tele.follower().position;
    tele.update(lost == 0 ? bad : leader, lost == 1 ? bad : none, lost == 2 ? bad : none);
    EXPECT_FALSE(tele.is_engaged()) << lost;
    EXPECT_EQ(tele.follower().position, here) << lost;
    EXPECT_EQ(tele.follower().velocity, none) << lost;
    EXPECT_EQ(tele.leader_force(), none) << lost;
    tele.clutch(true);
    tele.update(leader, none, leader);
    EXPECT_TRUE(tele.is_engaged()) << lost;
    EXPECT_EQ(tele.follower().position, here) << lost;
    EXPECT_TRUE(tele.leader_force().allFinite()) << lost;
  }
}

TEST(BadNumbers, AnObjectKeepsItsMotionIfAHandPositionIsNotFinite) {
  ObjectImpedanceOptions o;
  o.grasps = {{0.05, 0.01, 0.0}, {-0.03, 0.05, 0.01}, {-0.02, -0.05, 0.02}};
  ObjectImpedance control(o);
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.1, Eigen::Vector3d(1, 2, 2) / 3.0).toRotationMatrix();
  std::vector<Eigen::Vector3d> hands, still(3, Eigen::Vector3d::Zero());
  for (const Eigen::Vector3d& grasp : o.grasps) hands.push_back(R * grasp);
  for (int k = 0; k < 10; ++k) control.estimate(hands, still);
  for (const double bad : {kNan, kInf}) {
    auto lost = hands, fast = still;
    lost[1].x() = bad;
    fast[2].z() = bad;
    EXPECT_LT((control.estimate(lost, still).rotation - R).norm(), 1e-9);
    EXPECT_LT(control.estimate(hands, fast).spin.norm(), 1e-9);
    EXPECT_LT(control.estimate(lost, still).position.norm(), 1e-9);
  }
  auto far = hands;
  far[0].y() = 1e200;  // finite, but not its square
  control.estimate(far, still);
  for (int k = 0; k < 10; ++k) control.estimate(hands, still);
  EXPECT_LT((control.estimate(hands, still).rotation - R).norm(), 1e-9);
}

// Internal forces need two hands at two places and a number.
TEST(BadNumbers, NonFiniteInternalForcesAreRefused) {
  ObjectImpedanceOptions o;
  o.grasps = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  ObjectImpedance control(o);
  for (const auto& [hand, other, force] : {std::tuple{-1, 1, 1.0}, {0, -1, 1.0}, {2, 0, 1.0}, {0, 2, 1.0},
                                           {1, 1, 1.0}, {0, 1, kNan}})
    EXPECT_FALSE(control.set_internal_force(hand, other, force)) << hand << other << force;
  EXPECT_TRUE(control.set_internal_force(0, 1, 3.0));
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  for (const TipTarget& target : control.update({}, {}, none, none)) EXPECT_EQ(target.force, none);
}

}  // namespace
}  // namespace veridyn
