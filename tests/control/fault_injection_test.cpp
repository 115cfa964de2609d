#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "control/arm_rig.hpp"
#include "control/psm_like.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/impedance.hpp"
#include "veridyn/control/model_error_observer.hpp"
#include "veridyn/control/momentum_observer.hpp"
#include "veridyn/control/quintic_interpolator.hpp"
#include "veridyn/control/safety_supervisor.hpp"

// What breaks in a laboratory, in the middle of a pull of 12 N on a spring or of a free move. The
// claim: the true joints stay within their limits, the true force below kMostForce, and the arm
// comes to rest.

namespace veridyn {
namespace {

const Tip kTip{"tool"};
constexpr double kMostForce = 25.0;  // [N]; the supervisor's own limit is 15 N
constexpr double kSpring = 2450.0;   // [N/m]
constexpr double kMotors = 40.0;     // [N m], [N]

// An impedance controller with everything around it, on an arm whose sensors can be tampered with.
class Loop {
 public:
  explicit Loop(bool with_spring, double motors = kMotors)
      : real_(counterbalanced_psm_like()),
        wrong_(with_wrong_parameters(real_, 0.1, 2)),
        rig_(real_, kTip),
        state_(wrong_, kTip),
        control_(wrong_, kTip, gains()),
        friction_(wrong_),
        error_(3, {10.0, VectorXd::Constant(3, 3.0)}),
        momentum_(wrong_, kTip),
        safety_(wrong_, limits(motors)),
        input_(3),
        velocity_(3),
        way_(VectorXd::Zero(3)),
        tau_(VectorXd::Zero(3)),
        motors_(tau_),
        none_(tau_) {
    rig_.set_limit(VectorXd::Constant(3, motors));
    rig_.place(Eigen::Vector3d(0.1, 0.05, 0.12));
    q_ = rig_.q();
    start_ = rig_.tip().position();
    way_.reset(start_);
    const Eigen::Vector3d start = start_;
    if (with_spring)
      rig_.set_world([start](const Eigen::Vector3d& x, const Eigen::Vector3d&) -> Eigen::Vector3d {
        return kSpring * Eigen::Vector3d(x.x() - start.x(), 0, 0);
      });
    input_.q_wanted.setConstant(NAN);  // the law gives way on purpose
    EXPECT_TRUE(safety_.enable());
    EXPECT_TRUE(safety_.activate());
  }

  static ImpedanceGains gains() {
    ImpedanceGains g;
    g.mass.head<3>().setConstant(2.0);
    g.damping.head<3>().setConstant(100.0);
    g.stiffness.head<3>().setConstant(100.0);
    return g;
  }

  SafetyLimits limits(double motors) const {
    SafetyLimits limits = safety_limits(real_, motors);
    for (int i = 0; i < 3; ++i) limits.velocity[i] = largest_speed(i);
    return limits;
  }

  void pull(double force, double seconds) {
    const VectorXd goal = start_ + force * (1.0 / kSpring + 1.0 / 100.0) * Eigen::Vector3d::UnitX();
    EXPECT_TRUE(way_.move_to(goal, seconds));
  }
  void move(const Eigen::Vector3d& by, double seconds) {
    const VectorXd goal = start_ + by;
    EXPECT_TRUE(way_.move_to(goal, seconds));
  }

  void run(double seconds) {
    const int cycles = static_cast<int>(std::lround(seconds / kPeriod));
    for (int k = 0; k < cycles; ++k) cycle();
  }

  // What may be done to the sensors and motors; all sound at first.
  double position_jump = 0.0;  // [rad] on yaw
  bool positions_lost = false;
  int positions_stale = 0;  // cycles for which the last one is repeated, told by its age
  bool force_stuck = false;

  const SafetySupervisor& safety() const { return safety_; }
  double most_force() const { return most_force_; }
  double least_room() const { return least_room_; }  // to the nearest limit, in ranges
  double speed() { return rig_.engine().dq().cwiseAbs().maxCoeff(); }
  double fastest() const { return fastest_; }
  ArmRig& rig() { return rig_; }
  const Impedance& control() const { return control_; }

 private:
  void sense() {
    if (positions_stale > 0) {
      --positions_stale;
      input_.sensor_age += kPeriod;
      velocity_.update(lost_, none_, kPeriod);
    } else {
      q_ = rig_.q();
      q_[0] += position_jump;
      if (positions_lost) q_.setConstant(NAN);
      input_.sensor_age = 0.0;
      velocity_.update(q_, none_, kPeriod);
    }
    state_.update(q_, velocity_.dq());
    if (!force_stuck) force_ = rig_.wrench();
  }

  void cycle() {
    sense();
    way_.advance(kPeriod);
    wanted_.x.head<3>() = way_.x();
    momentum_.update(state_, motors_, control_.acceleration(), kPeriod);
    tau_ = control_.update(state_, wanted_, force_);
    tau_ += friction_.update(state_, control_.joint_velocity(), control_.joint_error(), kPeriod);
    tau_ += error_.update(state_, control_.acceleration(), kPeriod);
    input_.force = force_.head<3>();
    input_.force_expected = momentum_.force();
    safety_.set_holding_torque(error_.torque());
    motors_ = safety_.update(state_, input_, tau_);
    EXPECT_EQ(rig_.cycle(motors_), StepStatus::kOk);
    most_force_ = std::max(most_force_, rig_.force().norm());
    for (int i = 0; i < 3; ++i) {
      const Limits& l = real_.coordinates()[i].limits;
      const double q = rig_.engine().q()[i];
      least_room_ = std::min(least_room_, std::min(q - l.lower, l.upper - q) / (l.upper - l.lower));
      fastest_ = std::max(fastest_, std::abs(rig_.engine().dq()[i]) / largest_speed(i));
    }
  }
  static double largest_speed(int i) { return i == 2 ? 0.2 : 1.0; }

  Model real_, wrong_;
  ArmRig rig_;
  ArmState state_;
  Impedance control_;
  FrictionCompensation friction_;
  ModelErrorObserver error_;
  MomentumObserver momentum_;
  SafetySupervisor safety_;
  SafetyInput input_;
  VelocityObserver velocity_;
  QuinticInterpolator way_;
  TaskReference wanted_;
  VectorXd q_, tau_, motors_, none_;
  VectorXd lost_{VectorXd::Constant(3, NAN)};
  Vector6d force_{Vector6d::Zero()};
  Eigen::Vector3d start_;
  double most_force_ = 0.0, least_room_ = 1.0, fastest_ = 0.0;
};

// After a fault, two seconds later.
void expect_safe(Loop& loop, SafetyFault fault) {
  EXPECT_EQ(loop.safety().fault(), fault) << describe(loop.safety().fault());
  EXPECT_LT(loop.most_force(), kMostForce);
  EXPECT_GT(loop.least_room(), 0.0);
  EXPECT_LT(loop.speed(), 1e-3);
}

TEST(FaultInjection, WithoutInjectedFaultsNoFaultIsReported) {
  Loop loop(true);
  loop.pull(12.0, 2.0);
  loop.run(4.0);
  expect_safe(loop, SafetyFault::kNone);
  EXPECT_NEAR(loop.rig().force().x(), 12.0, 0.1);
}

TEST(FaultInjection, ShortDropoutsAreTolerated) {
  Loop loop(true);
  loop.pull(12.0, 2.0);
  for (int k = 0; k < 40; ++k) {
    loop.positions_stale = 2;
    loop.run(0.1);
  }
  expect_safe(loop, SafetyFault::kNone);
  EXPECT_NEAR(loop.rig().force().x(), 12.0, 0.1);
}

// In the middle of a pull on the spring, or of a free motion.
void begin_moving(Loop& loop, bool with_spring) {
  if (with_spring)
    loop.pull(12.0, 2.0);
  else
    loop.move({0.05, -0.04, 0.05}, 0.8);
  loop.run(with_spring ? 1.0 : 0.4);
}

TEST(FaultInjection, LongDropoutsStopTheArm) {
  for (const bool with_spring : {true, false}) {
    Loop loop(with_spring);
    begin_moving(loop, with_spring);
    loop.positions_stale = 1000000;
    loop.run(2.0);
    expect_safe(loop, SafetyFault::kSensorAge);
  }
}

TEST(FaultInjection, AnEncoderWithoutReadingsStopsTheArm) {
  for (const bool with_spring : {true, false}) {
    Loop loop(with_spring);
    begin_moving(loop, with_spring);
    loop.positions_lost = true;
    loop.run(2.0);
    expect_safe(loop, SafetyFault::kNotFinite);
  }
}

TEST(FaultInjection, AnEncoderThatJumpsStopsTheArm) {
  for (const bool stays : {true, false}) {
    Loop loop(true);
    loop.pull(12.0, 2.0);
    loop.run(1.5);
    loop.position_jump = 0.1;
    loop.run(kPeriod);
    if (!stays) loop.position_jump = 0.0;
    loop.run(2.0);
    expect_safe(loop, SafetyFault::kEncoderJump);
  }
}

TEST(FaultInjection, AStuckForceSensorIsDetectedAndTheForceFallsBelow3Newton) {
  Loop loop(true);
  loop.pull(12.0, 2.0);
  loop.run(0.5);
  loop.force_stuck = true;
  loop.run(4.0);
  expect_safe(loop, SafetyFault::kForceSensor);
  EXPECT_LT(loop.rig().force().norm(), 3.0);  // it let go
}

TEST(FaultInjection, ExcessiveForceReleasesTheArm) {
  Loop loop(true);
  loop.pull(20.0, 2.0);
  loop.run(5.0);
  expect_safe(loop, SafetyFault::kForce);
  EXPECT_LT(loop.rig().force().norm(), 3.0);
}

// Motors that have less to give than the law asks for.
TEST(FaultInjection, SaturatedMotorsStopTheArm) {
  for (const bool with_spring : {true, false}) {
    Loop loop(with_spring, 1.5);
    if (with_spring)
      loop.pull(40.0, 2.0);
    else
      loop.move({0.05, -0.05, 0.05}, 0.4);
    loop.run(4.0);
    expect_safe(loop, SafetyFault::kTorque);
  }
}

// Straight through the remote centre, where yaw and pitch cannot move the tip: damped, no joint
// runs away, and what would leave the limits is stopped.
TEST(FaultInjection, NoJointDivergesThroughASingularPose) {
  Loop loop(false);
  const Eigen::Vector3d start = loop.rig().tip().position();
  // Along the tool back to the remote centre, a hair beside it, and 5 mm sideways there.
  VectorXd q = loop.rig().q();
  q[2] = 0.0156;
  TipKinematics tip(counterbalanced_psm_like(), kTip);
  tip.update(q, VectorXd::Zero(3));
  loop.move(tip.position() - start + Eigen::Vector3d(0.005, 0.002, 0), 3.0);
  double smallest = 1.0;
  for (int k = 0; k < 50; ++k) {
    loop.run(0.1);
    smallest = std::min(smallest, loop.control().inverse().smallest_singular_value());
  }
  EXPECT_LT(smallest, 0.05);  // it was there
  EXPECT_LT(loop.fastest(), 1.1);
  EXPECT_GT(loop.least_room(), 0.0);
  loop.run(1.0);
  EXPECT_LT(loop.speed(), 0.05);
}

}  // namespace
}  // namespace veridyn
