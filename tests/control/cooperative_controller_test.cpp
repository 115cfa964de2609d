#include "veridyn/control/cooperative_controller.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPeriod = 1e-3;

Matrix3d about(double angle, const Vector3d& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

const std::vector<Vector3d> kTips{{0.1, 0.0, 0.05}, {0.2, 0.02, 0.04}, {0.16, 0.11, 0.06}};

CooperativeOptions options(int arms) {
  CooperativeOptions o;
  for (int k = 0; k < arms; ++k) o.R_world_arm.push_back(about(0.7 * k, {0.1 * k, 0.2, 1.0}));
  o.period = kPeriod;
  return o;
}

std::vector<Vector3d> tips(int arms) {
  return {kTips.begin(), kTips.begin() + arms};
}

// Tips that are exactly where they shall be, with ideal sensors of `force`.
void follow(CooperativeController& control, CooperativeInput& input, int steps,
            const std::function<double(const CooperativeInput&)>& force = {}) {
  for (int k = 0; k < steps; ++k) {
    for (ForceReading& reading : input.force) {
      reading.force = force ? force(input) : 0.0;
      reading.number = reading.number.value_or(-1) + 1;
    }
    const auto& targets = control.update(input);
    for (size_t i = 0; i < targets.size(); ++i) {
      input.velocity[i] = (targets[i].position - input.position[i]) / kPeriod;
      input.position[i] = targets[i].position;
    }
  }
}

CooperativeInput at(const std::vector<Vector3d>& where, int members) {
  CooperativeInput input(static_cast<int>(where.size()), members);
  input.position = where;
  return input;
}

// (6.2): every arm moves by (R_follower_leader)' dx in its own axes, for dx in the leader's.
TEST(CooperativeController, MovesEveryArmByTheSameDisplacementInItsOwnAxes) {
  CooperativeOptions o = options(3);
  o.leader = 1;
  CooperativeController control(o, kTips);
  CooperativeInput input = at(kTips, 0);
  const Vector3d dx(0.01, -0.004, 0.002);
  ASSERT_TRUE(control.move(dx, 0.5));
  follow(control, input, 600);
  for (size_t i = 0; i < 3; ++i) {
    const Matrix3d R_leader_arm = o.R_world_arm[1].transpose() * o.R_world_arm[i];
    const Vector3d moved = o.R_world_arm[i].transpose() * (input.position[i] - kTips[i]);
    EXPECT_NEAR((moved - R_leader_arm.transpose() * dx).norm(), 0.0, 1e-12) << i;
  }
}

// (6.3) with the errata: x_d increases by (R - 1)(-c), where c points from the tip to the centroid
// and R is Rz(c) Ry(b) Rx(a) in the leader's axes.
TEST(CooperativeController, TurnsTheObjectAboutItsCentroid) {
  CooperativeOptions o = options(3);
  CooperativeController control(o, kTips);
  CooperativeInput input = at(kTips, 0);
  const Vector3d euler(0.2, -0.3, 0.4);
  ASSERT_TRUE(control.rotate(euler, 0.5));
  EXPECT_FALSE(control.rotate(euler, 0.5));  // one after the other
  follow(control, input, 600);
  const Matrix3d R_leader = about(0.4, {0, 0, 1}) * about(-0.3, {0, 1, 0}) * about(0.2, {1, 0, 0});
  const Matrix3d R = o.R_world_arm[0] * R_leader * o.R_world_arm[0].transpose();
  const Vector3d centre = (kTips[0] + kTips[1] + kTips[2]) / 3.0;
  for (size_t i = 0; i < 3; ++i) {
    const Vector3d c = centre - kTips[i];
    const Vector3d wanted = kTips[i] + (R - Matrix3d::Identity()) * (-c);
    EXPECT_NEAR((input.position[i] - wanted).norm(), 0.0, 1e-12) << i;
  }
  ASSERT_TRUE(control.rotate({0.0, 0.0, 0.1}, 0.5));  // a second one adds to the first
  follow(control, input, 600);
  const Matrix3d R2 =
      o.R_world_arm[0] * about(0.1, {0, 0, 1}) * R_leader * o.R_world_arm[0].transpose();
  EXPECT_NEAR((input.position[2] - centre - R2 * (kTips[2] - centre)).norm(), 0.0, 1e-12);
}

// Targets' velocities and accelerations are those of their positions.
TEST(CooperativeController, TargetVelocitiesAndAccelerationsMatchFiniteDifferences) {
  CooperativeController control(options(3), kTips);
  CooperativeInput input = at(kTips, 0);
  control.move({0.02, 0.01, -0.01}, 1.0);
  control.rotate({0.3, 0.2, -0.4}, 0.8);
  control.move_arm(2, {0.01, 0.0, 0.005}, 0.6);
  std::vector<TipTarget> before, here;
  for (int k = 0; k < 900; ++k) {
    const std::vector<TipTarget> next = control.update(input);
    for (size_t i = 0; i < 3; ++i) input.position[i] = next[i].position;
    if (!before.empty()) {
      for (size_t i = 0; i < 3; ++i) {
        const Vector3d v = (next[i].motion - before[i].motion) / (2.0 * kPeriod);
        const Vector3d a =
            (next[i].motion - 2.0 * here[i].motion + before[i].motion) / (kPeriod * kPeriod);
        EXPECT_NEAR((v - here[i].velocity).norm(), 0.0, 2e-5) << k;
        EXPECT_NEAR((a - here[i].acceleration).norm(), 0.0, 5e-3) << k;
      }
    }
    before = here;
    here = next;
  }
}

// (6.4): along the object, and only followers.
TEST(CooperativeController, ExpandGraspMovesOnlyTheFollowerAwayAlongTheObject) {
  CooperativeController control(options(2), tips(2));
  CooperativeInput input = at(tips(2), 0);
  ASSERT_TRUE(control.expand_grasp(0.003, 0.2));
  follow(control, input, 300);
  const Vector3d u = (kTips[1] - kTips[0]).normalized();
  EXPECT_NEAR((input.position[1] - kTips[1] - 0.003 * u).norm(), 0.0, 1e-12);
  EXPECT_NEAR((input.position[0] - kTips[0]).norm(), 0.0, 1e-12);
}

// (7.12) with the errata: too little tension makes the follower pull away, whichever end it is on and
// whoever the leader is.
TEST(CooperativeController, TooLittleTensionMakesTheFollowerPullAway) {
  for (const int leader : {0, 1}) {
    for (const bool turned : {false, true}) {
      CooperativeOptions o = options(2);
      o.leader = leader;
      ForceLaw law;
      law.gain = 0.01;
      o.members = {turned ? CooperativeMember{1, 0, law, 1.0} : CooperativeMember{0, 1, law, 1.0}};
      CooperativeController control(o, tips(2));
      CooperativeInput input = at(tips(2), 1);
      const double before = (kTips[1] - kTips[0]).norm();
      ASSERT_TRUE(control.set_force(0, 5.0, 0.01));
      follow(control, input, 100);  // the sensor says 0
      EXPECT_GT((input.position[1] - input.position[0]).norm(), before + 1e-4);
      const auto m = static_cast<size_t>(leader);
      EXPECT_EQ(input.position[m], kTips[m]);
    }
  }
}

// Ideal arms on a spring: the force reaches what is wanted, for both laws, and the time constant of
// the proportional one is 1 / (gain * stiffness).
TEST(CooperativeController, TracksTheForceOfASpring) {
  for (const auto kind : {ForceLaw::Kind::kIncrement, ForceLaw::Kind::kProportional}) {
    CooperativeOptions o = options(2);
    ForceLaw law;
    law.kind = kind;
    law.gain = 0.01;
    law.increment = 1e-5;
    law.deadband = kind == ForceLaw::Kind::kIncrement ? 0.02 : 0.0;
    o.members = {{0, 1, law, 1.0}};
    CooperativeController control(o, tips(2));
    CooperativeInput input = at(tips(2), 1);
    const double rest = (kTips[1] - kTips[0]).norm();
    const auto spring = [&](const CooperativeInput& now) {
      return 1000.0 * ((now.position[1] - now.position[0]).norm() - rest);
    };
    control.set_force(0, 5.0, kPeriod);
    follow(control, input, 101, spring);
    if (kind == ForceLaw::Kind::kProportional) {
      EXPECT_NEAR(spring(input), 5.0 * (1.0 - std::exp(-1.0)), 0.1);
    }
    follow(control, input, 2000, spring);
    EXPECT_NEAR(spring(input), 5.0, 0.021);
    EXPECT_EQ(control.state(), CooperativeState::kTracking);
  }
}

struct Tracking {
  explicit Tracking(double drift_force = CooperativeOptions().drift_force) {
    ForceLaw law;
    law.gain = 0.005;
    law.stiffness = 1000.0;
    CooperativeOptions o = options(2);
    o.members = {{0, 1, law, 1.0}};
    o.largest_force_error = 8.0;
    o.largest_error = 0.05;
    o.drift_force = drift_force;
    control = std::make_unique<CooperativeController>(o, tips(2));
    rest = (kTips[1] - kTips[0]).norm();
    control->set_force(0, 5.0, 0.1);
    run(3000);
  }
  double spring(const CooperativeInput& now) const {
    return 1000.0 * ((now.position[1] - now.position[0]).norm() - rest);
  }
  void run(int steps) {
    follow(*control, input, steps, [&](const CooperativeInput& now) { return spring(now); });
  }
  std::unique_ptr<CooperativeController> control;
  CooperativeInput input = at(tips(2), 1);
  double rest = 0.0;
};

TEST(CooperativeController, HoldsAndReportsWhenAnArmIsLost) {
  Tracking t;
  t.control->move({0.02, 0.0, 0.0}, 1.0);
  t.run(500);
  t.input.healthy[1] = 0;
  t.run(1);
  EXPECT_EQ(t.control->state(), CooperativeState::kArmLost);
  EXPECT_NE(std::string(describe(t.control->state())), "");
  EXPECT_FALSE(t.control->move({0.01, 0.0, 0.0}, 1.0));
  EXPECT_FALSE(t.control->set_force(0, 1.0, 1.0));
  t.run(150);
  const Vector3d here = t.input.position[0];
  t.run(1000);
  EXPECT_LT((t.input.position[0] - here).norm(), 1e-9);
  EXPECT_LT((here - kTips[0]).norm(), 0.015);  // the rest of the way was not gone
  t.input.healthy[1] = 1;
  t.control->restart(t.input.position);
  EXPECT_EQ(t.control->state(), CooperativeState::kTracking);
}

// A stop in the middle of a change of forces: they stay where they are, and another command goes on from there.
TEST(CooperativeController, AStopDuringAForceChangeKeepsTheForceReached) {
  Tracking t;
  ASSERT_TRUE(t.control->set_force(0, 9.0, 2.0));
  t.run(1000);
  t.control->stop();
  t.run(static_cast<int>(std::lround(CooperativeOptions().stop_duration / kPeriod)) + 1);
  const double stopped = t.control->wanted_force(0);
  EXPECT_NEAR(stopped, 7.0, 0.5);
  t.run(2000);
  EXPECT_EQ(t.control->wanted_force(0), stopped);
  EXPECT_EQ(t.control->state(), CooperativeState::kTracking);
  ASSERT_TRUE(t.control->set_force(0, 5.0, 0.5));
  t.run(600);
  EXPECT_EQ(t.control->wanted_force(0), 5.0);
}

TEST(CooperativeController, HoldsTheTargetsIfSamplesAreOldOrStuck) {
  Tracking stale;
  stale.input.force[0].age = 0.05;
  stale.run(1);
  EXPECT_EQ(stale.control->state(), CooperativeState::kSensorStale);

  Tracking stuck;
  stuck.control->set_force(0, 7.0, 0.5);
  const double frozen = 5.0001;
  for (int k = 0; k < 1000; ++k) {
    follow(*stuck.control, stuck.input, 1, [&](const CooperativeInput&) { return frozen; });
    if (stuck.control->state() != CooperativeState::kTracking) break;
  }
  EXPECT_EQ(stuck.control->state(), CooperativeState::kSensorStuck);
  EXPECT_NEAR(stuck.spring(stuck.input), 5.0, 1.2);  // stuck_force of 1 N
}

// A law that tracks a sensor whose zero creeps stretches the spring until its length gives it away;
// without the comparison it goes on.
TEST(CooperativeController, ADriftingSensorEndsTheTaskIfItIsComparedWithTheLength) {
  for (const double rate : {1.0, -1.0}) {
    for (const bool compared : {true, false}) {
      Tracking t(compared ? CooperativeOptions().drift_force : 1e9);
      t.control->set_force(0, 5.0, 0.5);
      t.run(1000);
      double off = 0.0;
      for (int k = 0; k < 4000 && t.control->state() == CooperativeState::kTracking; ++k) {
        off += 1e-3 * rate;
        follow(*t.control, t.input, 1, [&](const CooperativeInput& now) { return t.spring(now) + off; });
      }
      EXPECT_EQ(t.control->state(),
                compared ? CooperativeState::kSensorDrifted : CooperativeState::kTracking) << rate;
      EXPECT_LT(std::abs(off), compared ? 1.8 : 4.1);  // 1.5 times drift_force and 0.5 mm of 1 kN/m
    }
  }
}

TEST(CooperativeController, AnExcessiveForceEndsTheTaskAndIsReduced) {
  Tracking t;
  t.input.position[1] += Vector3d(0.03, 0.0, 0.0);  // pulled away: 30 N
  const double before = t.spring(t.input);
  ASSERT_GT(before, 25.0);
  t.run(1);
  EXPECT_EQ(t.control->state(), CooperativeState::kForceTooLarge);
  t.run(1000);
  EXPECT_LT(t.spring(t.input), 6.0);
}

TEST(CooperativeController, ANonFinitePositionEndsTheTask) {
  Tracking t;
  t.input.position[1].x() = NAN;
  const auto& targets = t.control->update(t.input);
  EXPECT_EQ(t.control->state(), CooperativeState::kNotFinite);
  for (const TipTarget& target : targets) EXPECT_TRUE(target.position.allFinite());
}

// Once targets are held, what is no number leaves no trace either: an arm that is lost often has none.
TEST(CooperativeController, NonFinitePositionsDuringAHoldLeaveTargetsUnchanged) {
  const auto breaks = {+[](CooperativeInput& in) { in.position[1].x() = NAN; },
                       +[](CooperativeInput& in) { in.velocity[1].y() = NAN; },
                       +[](CooperativeInput& in) { in.force[0].force = NAN; },
                       +[](CooperativeInput& in) { in.force[0].force = INFINITY; },
                       +[](CooperativeInput& in) { in.force[0].age = NAN; }};
  for (const auto& make : breaks) {
    Tracking t;
    t.input.healthy[1] = 0;
    t.run(200);
    EXPECT_EQ(t.control->state(), CooperativeState::kArmLost);
    const std::vector<TipTarget> before = t.control->update(t.input);
    CooperativeInput bad = t.input;
    make(bad);
    for (const CooperativeInput& input : {bad, t.input}) {
      const std::vector<TipTarget>& now = t.control->update(input);
      for (size_t i = 0; i < 2; ++i) {
        EXPECT_LT((now[i].position - before[i].position).norm(), 1e-6);
        EXPECT_LT((now[i].velocity - before[i].velocity).norm(), 1e-6);
        EXPECT_LT(now[i].acceleration.norm(), 1e-3);
      }
    }
  }
}

// A reading without a number, or without an age, ends the task like a position without one.
TEST(CooperativeController, ANonFiniteReadingEndsTheTask) {
  Tracking number, age;
  number.input.force[0].force = NAN;
  number.control->update(number.input);
  EXPECT_EQ(number.control->state(), CooperativeState::kNotFinite);
  EXPECT_FALSE(number.control->rotate({0.1, 0.0, 0.0}, 1.0));
  EXPECT_FALSE(number.control->expand_grasp(0.001, 1.0));
  EXPECT_FALSE(number.control->move_arm(1, {0.001, 0.0, 0.0}, 1.0));
  EXPECT_FALSE(number.control->track(0, false));
  std::vector<Vector3d> nowhere = number.input.position;
  nowhere[1].z() = NAN;
  number.control->restart(nowhere);  // targets stay where they were
  for (const TipTarget& target : number.control->update(number.input))
    EXPECT_TRUE(target.position.allFinite() && target.velocity.allFinite());
  number.control->restart(number.input.position);
  number.run(10);
  EXPECT_EQ(number.control->state(), CooperativeState::kTracking);
  age.input.force[0].age = NAN;
  age.control->update(age.input);
  EXPECT_EQ(age.control->state(), CooperativeState::kSensorStale);
}

// Commands with a number out of range are refused and change nothing.
TEST(CooperativeController, InvalidCommandsLeaveTheTargetsUnchanged) {
  Tracking t;
  CooperativeController& c = *t.control;
  for (const double time : {0.0, -1.0, static_cast<double>(NAN), HUGE_VAL}) {
    EXPECT_FALSE(c.move({0.01, 0.0, 0.0}, time));
    EXPECT_FALSE(c.rotate({0.1, 0.0, 0.0}, time));
    EXPECT_FALSE(c.expand_grasp(0.01, time));
    EXPECT_FALSE(c.move_arm(0, {0.01, 0.0, 0.0}, time));
    EXPECT_FALSE(c.set_force(0, 1.0, time));
  }
  EXPECT_FALSE(c.move({NAN, 0.0, 0.0}, 1.0));
  EXPECT_FALSE(c.rotate({0.0, NAN, 0.0}, 1.0));
  EXPECT_FALSE(c.expand_grasp(NAN, 1.0));
  EXPECT_FALSE(c.move_arm(0, {0.0, 0.0, NAN}, 1.0));
  EXPECT_FALSE(c.set_force(0, NAN, 1.0));
  for (const int none : {-1, 2}) EXPECT_FALSE(c.move_arm(none, {0.01, 0.0, 0.0}, 1.0));
  for (const int none : {-1, 1}) EXPECT_FALSE(c.set_force(none, 1.0, 1.0) || c.track(none, true));
  const std::vector<Vector3d> before = t.input.position;
  t.run(100);
  for (size_t i = 0; i < 2; ++i) EXPECT_LT((t.input.position[i] - before[i]).norm(), 1e-6);
}

// Force control that is on already goes on: neither the correction nor the checks of its sensor start
// afresh. A member that is not tracked may have any reading.
TEST(CooperativeController, ReenablingForceControlKeepsItsCorrection) {
  Tracking t;
  const double correction = t.control->correction(0);
  EXPECT_GT(correction, 1e-3);
  for (int k = 0; k < 30; ++k) {  // a sensor that has not begun to speak is found all the same
    EXPECT_EQ(t.control->track(0, true), t.control->state() == CooperativeState::kTracking) << k;
    t.input.force[0].number.reset();
    t.control->update(t.input);
    EXPECT_NEAR(t.control->correction(0), correction, 1e-6) << k;
  }
  EXPECT_EQ(t.control->state(), CooperativeState::kSensorStale);
  Tracking off;
  EXPECT_TRUE(off.control->track(0, false));
  off.input.force[0].force = 1e3;
  off.control->update(off.input);
  EXPECT_EQ(off.control->state(), CooperativeState::kTracking);
}

// The other reasons that end a task, and who gives way: an end whose arm does not follow is told nothing.
TEST(CooperativeController, EveryFaultInputEndsTheTask) {
  Tracking missed, error;
  missed.input.force[0].force = -5.0;
  missed.input.force[0].number = 100000;
  missed.control->update(missed.input);
  EXPECT_EQ(missed.control->state(), CooperativeState::kForceMissed);
  error.input.position[0].x() += 0.1;
  error.control->update(error.input);
  EXPECT_EQ(error.control->state(), CooperativeState::kTargetMissed);
  for (const int lost : {0, 1}) {
    Tracking t;
    t.input.healthy[lost] = 0;
    t.input.located[lost] = 0;
    t.control->update(t.input);
    t.input.force[0].force = 15.0;
    const std::vector<TipTarget> before = t.control->update(t.input);
    for (int k = 0; k < 10; ++k) t.control->update(t.input);
    const std::vector<TipTarget> after = t.control->update(t.input);
    EXPECT_EQ(after[lost].relief.position, Vector3d(Vector3d::Zero())) << lost;
    EXPECT_GT((after[1 - lost].relief.position - before[1 - lost].relief.position).norm(), 1e-4) << lost;
  }
}

TEST(CooperativeController, RejectsInvalidOptions) {
  CooperativeOptions o = options(2);
  EXPECT_THROW(CooperativeController(o, tips(1)), InvalidInput);
  o.members = {{0, 0, {}, 1.0}};
  EXPECT_THROW(CooperativeController(o, tips(2)), InvalidInput);
  o.members = {{0, 2, {}, 1.0}};
  EXPECT_THROW(CooperativeController(o, tips(2)), InvalidInput);
  o.members = {};
  o.leader = 5;
  EXPECT_THROW(CooperativeController(o, tips(2)), InvalidInput);
  o.leader = 0;
  o.period = 0.0;
  EXPECT_THROW(CooperativeController(o, tips(2)), InvalidInput);
}

}  // namespace
}  // namespace veridyn
