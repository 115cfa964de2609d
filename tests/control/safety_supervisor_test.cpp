#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "control/control_support.hpp"
#include "veridyn/control/safety_supervisor.hpp"
#include "veridyn/control/torque_uncertainty.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn {
namespace {

constexpr double kTorque = 30.0;

// An active supervisor that has seen one sound cycle.
class Supervised {
 public:
  Supervised()
      : arm_(plausible_model(read_model("psm-3dof"), 1).arm),
        state_(arm_, {"tool"}),
        safety_(arm_, safety_limits(arm_, kTorque)),
        input_(3) {
    q_ << 0.1, 0.2, 0.1;
    tau_ << 1, 2, 3;
    input_.q_wanted = q_;
    EXPECT_TRUE(safety_.enable());
    EXPECT_TRUE(safety_.activate());
    run();
    EXPECT_EQ(safety_.fault(), SafetyFault::kNone);
  }

  const VectorXd& run() {
    state_.update(q_, dq_);
    return safety_.update(state_, input_, tau_);
  }

  Model arm_;
  ArmState state_;
  SafetySupervisor safety_;
  SafetyInput input_;
  VectorXd q_{VectorXd::Zero(3)}, dq_{VectorXd::Zero(3)}, tau_{VectorXd::Zero(3)};
};

struct Wrong {
  SafetyFault fault;
  std::optional<JointIndex> joint;
  SafetyAction action;
  void (*make)(Supervised&);
};

const Wrong kWrongs[] = {
    {SafetyFault::kNotFinite, {{1}}, SafetyAction::kFreeze, [](Supervised& s) { s.q_[1] = NAN; }},
    {SafetyFault::kNotFinite, {{2}}, SafetyAction::kFreeze, [](Supervised& s) { s.dq_[2] = INFINITY; }},
    {SafetyFault::kNotFinite, {}, SafetyAction::kFreeze, [](Supervised& s) { s.input_.dt = NAN; }},
    {SafetyFault::kNotFinite, {}, SafetyAction::kFreeze,
     [](Supervised& s) { s.input_.sensor_age = NAN; }},
    {SafetyFault::kSensorAge, {}, SafetyAction::kFreeze,
     [](Supervised& s) { s.input_.sensor_age = 0.004; }},
    {SafetyFault::kEncoderJump, {{0}}, SafetyAction::kFreeze, [](Supervised& s) { s.q_[0] += 0.05; }},
    {SafetyFault::kController, {{1}}, SafetyAction::kHold, [](Supervised& s) { s.tau_[1] = NAN; }},
    {SafetyFault::kOverrun, {}, SafetyAction::kHold, [](Supervised& s) { s.input_.dt = 0.02; }},
    {SafetyFault::kPosition, {{2}}, SafetyAction::kHold,
     [](Supervised& s) {
       // Still inside, but it could not stop before the limit at 0.24 m.
       for (; s.q_[2] < 0.2355; s.q_[2] += 5e-4) {
         s.input_.q_wanted = s.q_;
         s.run();
       }
       s.input_.q_wanted = s.q_;
       s.dq_[2] = 0.2;
     }},
    {SafetyFault::kVelocity, {{0}}, SafetyAction::kHold, [](Supervised& s) { s.dq_[0] = 2.1; }},
    {SafetyFault::kTracking, {{1}}, SafetyAction::kHold,
     [](Supervised& s) { s.input_.q_wanted[1] += 0.1; }},
    {SafetyFault::kTorque, {{2}}, SafetyAction::kHold,
     [](Supervised& s) {
       s.tau_[2] = 1.5 * kTorque;
       for (int k = 0; k < 199; ++k) s.run();
       EXPECT_EQ(s.safety_.fault(), SafetyFault::kNone);
       s.input_.dt = 0.002;
     }},
    {SafetyFault::kForce, {}, SafetyAction::kRelease,
     [](Supervised& s) { s.input_.force << 10, 10, 10; }},
    {SafetyFault::kForceSensor, {}, SafetyAction::kRelease,
     [](Supervised& s) { s.input_.force[1] = NAN; }},
    {SafetyFault::kForceSensor, {}, SafetyAction::kRelease,
     [](Supervised& s) { s.input_.force_age = 0.02; }},
    {SafetyFault::kForceSensor, {}, SafetyAction::kRelease,
     [](Supervised& s) {
       s.input_.force_expected << 0, 0, 8;
       for (int k = 0; k < 99; ++k) s.run();
       EXPECT_EQ(s.safety_.fault(), SafetyFault::kNone);
       s.input_.dt = 0.002;
     }},
};

TEST(SafetySupervisor, EveryFaultTriggersItsActionWithinOneCycleWithAReason) {
  for (const Wrong& wrong : kWrongs) {
    Supervised s;
    EXPECT_TRUE(near(s.run(), Eigen::Vector3d(1, 2, 3), 0.0));
    wrong.make(s);
    const VectorXd out = s.run();
    EXPECT_EQ(s.safety_.fault(), wrong.fault) << describe(wrong.fault);
    EXPECT_EQ(s.safety_.joint(), wrong.joint) << describe(wrong.fault);
    EXPECT_EQ(s.safety_.state(), SafetyState::kFault);
    EXPECT_EQ(s.safety_.action(), wrong.action) << describe(wrong.fault);
    EXPECT_EQ(action_of(wrong.fault), wrong.action);
    EXPECT_TRUE(out.allFinite());
    EXPECT_LE(out.cwiseAbs().maxCoeff(), kTorque);
    EXPECT_GT(std::string(describe(wrong.fault)).size(), 5U);
    // It stays until it is reset, however sound the next cycles are.
    s.dq_.setZero();
    if (wrong.action == SafetyAction::kFreeze) s.q_ << 0.1, 0.2, 0.1;
    s.run();
    EXPECT_EQ(s.safety_.fault(), wrong.fault);
    EXPECT_FALSE(s.safety_.activate());
    EXPECT_FALSE(s.safety_.enable());
    EXPECT_TRUE(s.safety_.reset());
    EXPECT_EQ(s.run().norm(), 0.0);
    EXPECT_TRUE(s.safety_.enable());
  }
}

TEST(SafetySupervisor, OnlyDefinedStateTransitionsAreAllowed) {
  Supervised s;
  SafetySupervisor& safety = s.safety_;
  EXPECT_FALSE(safety.home());
  EXPECT_FALSE(safety.enable());
  EXPECT_FALSE(safety.reset());
  EXPECT_TRUE(safety.hold());
  EXPECT_FALSE(safety.hold());
  // Holding, the controller's torque does not count: what counts is what keeps the arm there.
  s.tau_ << 9, 9, 9;
  s.run();
  EXPECT_EQ(safety.action(), SafetyAction::kHold);
  EXPECT_TRUE(near(s.run(), s.state_.bias(), 1e-9));
  EXPECT_TRUE(safety.activate());
  safety.disable();
  EXPECT_EQ(s.run().norm(), 0.0);
  EXPECT_FALSE(safety.activate());
  EXPECT_TRUE(safety.enable());
  EXPECT_FALSE(safety.homed());
  EXPECT_TRUE(safety.home());
  EXPECT_FALSE(safety.activate());
  // Homing is slow: a fifth of the velocity limit.
  s.input_.q_wanted = s.q_;
  s.dq_[0] = 0.3;
  s.run();
  EXPECT_EQ(safety.fault(), SafetyFault::kNone);
  EXPECT_TRUE(safety.homed());
  EXPECT_TRUE(safety.activate());
  s.dq_[0] = 0.5;
  s.run();
  EXPECT_EQ(safety.fault(), SafetyFault::kNone);
  safety.disable();
  EXPECT_TRUE(safety.enable());
  EXPECT_TRUE(safety.home());
  s.run();
  EXPECT_EQ(safety.fault(), SafetyFault::kVelocity);
}

// A lost encoder in motion: what is left brakes by what was last known, and ends in what holds.
TEST(SafetySupervisor, WithoutSensorsItBrakesByFourFifthsOfTheLastMomentum) {
  Supervised s;
  VectorXd extra = Eigen::Vector3d(0.1, -0.2, 0.3);
  s.safety_.set_holding_torque(extra);
  s.dq_ << 0.5, -0.3, 0.1;
  s.run();
  const VectorXd p = s.state_.mass_matrix() * s.dq_;
  s.q_.setConstant(NAN);
  VectorXd impulse = VectorXd::Zero(3);
  GravityCompensation gravity(s.arm_);
  const VectorXd holds = gravity.update(Eigen::Vector3d(0.1, 0.2, 0.1)) + extra;
  VectorXd out;
  for (int k = 0; k < 1000; ++k) {
    out = s.run();
    impulse += 1e-3 * (out - holds);
  }
  EXPECT_TRUE(near(out, holds, 1e-6));
  EXPECT_TRUE(near(impulse, -0.8 * p, 0.03 * p.norm()));
}

// What a controller makes of samples that did not come anew is not kept for the fault.
TEST(SafetySupervisor, OldSamplesDoNotAffectTheHeldPosition) {
  Supervised s;
  s.safety_.set_holding_torque(Eigen::Vector3d(0.1, 0.2, 0.3));
  s.run();
  for (const double age : {0.001, 0.002, 0.003}) {
    s.input_.sensor_age = age;
    s.safety_.set_holding_torque(Eigen::Vector3d(3, 3, 3));
    s.run();
    EXPECT_EQ(s.safety_.fault(), SafetyFault::kNone);
  }
  s.input_.sensor_age = 0.004;
  const VectorXd out = s.run();
  EXPECT_EQ(s.safety_.fault(), SafetyFault::kSensorAge);
  GravityCompensation gravity(s.arm_);
  const VectorXd holds = gravity.update(s.q_) + Eigen::Vector3d(0.1, 0.2, 0.3);
  EXPECT_TRUE(near(out, holds, 1e-9));
}

// The position is repeated for ten cycles, then a new one arrives. At 0.9 of its largest velocity the arm can have moved
// there meanwhile; at 2.2 times that velocity it cannot.
TEST(SafetySupervisor, APositionAfterAPauseIsAJumpOnlyIfUnreachable) {
  for (const double factor : {0.9, 2.2}) {
    Supervised s;
    SafetyLimits limits = safety_limits(s.arm_, kTorque);
    limits.sensor_age = 0.02;
    s.safety_ = SafetySupervisor(s.arm_, limits);
    EXPECT_TRUE(s.safety_.enable());
    s.run();
    for (int k = 1; k <= 10; ++k) {
      s.input_.sensor_age = s.input_.dt * k;
      s.run();
    }
    s.input_.sensor_age = 0.0;
    s.q_[0] += factor * limits.velocity[0] * 11.0 * s.input_.dt;
    s.run();
    EXPECT_EQ(s.safety_.fault(), factor < 1.0 ? SafetyFault::kNone : SafetyFault::kEncoderJump) << factor;
  }
}

// Positions that are always some cycles old are new ones: an arm that moves at 0.9 of its largest velocity is not
// stopped, and a jump is found.
TEST(SafetySupervisor, PositionsWithConstantLatencyAreAccepted) {
  for (const double cycles : {1.0, 1.7, 5.0}) {
    Supervised s;
    SafetyLimits limits = safety_limits(s.arm_, kTorque);
    limits.sensor_age = 0.02;
    s.safety_ = SafetySupervisor(s.arm_, limits);
    EXPECT_TRUE(s.safety_.enable());
    s.input_.sensor_age = cycles * s.input_.dt;
    s.run();
    for (int k = 0; k < 1000; ++k) {
      s.q_[0] += (k % 200 < 100 ? 0.9 : -0.9) * limits.velocity[0] * s.input_.dt;
      s.run();
    }
    EXPECT_EQ(s.safety_.fault(), SafetyFault::kNone) << cycles;
    s.q_[0] += 2.2 * limits.velocity[0] * s.input_.dt;
    s.run();
    EXPECT_EQ(s.safety_.fault(), SafetyFault::kEncoderJump) << cycles;
  }
}

// A reply that came late, whenever its position was measured: the arm may have moved for as long as the
// reply took, then or in the cycle after it. Without that range it has jumped.
TEST(SafetySupervisor, APositionInALateReplyIsNoJumpIfItsAgeRangeIsGiven) {
  for (const bool told : {true, false}) {
    for (const bool early : {true, false}) {  // measured at the begin or at the end of the wait
      Supervised s;
      SafetyLimits limits = safety_limits(s.arm_, kTorque);
      limits.sensor_age = limits.overrun = 0.02;
      s.safety_ = SafetySupervisor(s.arm_, limits);
      EXPECT_TRUE(s.safety_.enable());
      s.run();
      const double way = limits.velocity[0] * s.input_.dt, late = 9.0;
      s.input_.dt *= 1.0 + late;
      s.input_.sensor_age = late * 0.001;
      s.input_.sensor_age_range = told ? s.input_.sensor_age : 0.0;
      s.q_[0] += 0.9 * way * (early ? 1.0 : 1.0 + late);
      s.run();
      s.input_ = SafetyInput(3);
      s.input_.q_wanted = s.q_;
      s.q_[0] += 0.9 * way * (early ? 1.0 + late : 1.0);
      s.input_.dt = 0.001;
      s.run();
      EXPECT_EQ(s.safety_.fault(), told || early ? SafetyFault::kNone : SafetyFault::kEncoderJump) << early;
    }
  }
}

// One step of a coarse encoder is no jump; two are.
TEST(SafetySupervisor, OneEncoderIncrementIsNoJumpAndTwoAre) {
  for (const int steps : {1, 2}) {
    Supervised s;
    SafetyLimits limits = safety_limits(s.arm_, kTorque);
    limits.resolution = VectorXd::Constant(3, 3.0 * limits.velocity[0] * s.input_.dt);
    s.safety_ = SafetySupervisor(s.arm_, limits);
    EXPECT_TRUE(s.safety_.enable());
    s.run();
    s.q_[0] += steps * limits.resolution[0];
    s.run();
    EXPECT_EQ(s.safety_.fault(), steps == 1 ? SafetyFault::kNone : SafetyFault::kEncoderJump);
  }
}

// A motor that gives nearly all it has: while it moves that is work, at a standstill it presses.
TEST(SafetySupervisor, AMotorNearItsLimitIsSaturatedOnlyAtAStandstill) {
  for (const double share : {0.93, 0.97}) {
    for (const double speed : {0.0, 0.1}) {  // of the velocity limit
      Supervised s;
      s.tau_[2] = share * kTorque;
      s.dq_[2] = speed * safety_limits(s.arm_, kTorque).velocity[2];
      for (int k = 0; k < 250; ++k) s.run();
      EXPECT_EQ(s.safety_.fault(), share > 0.95 && speed == 0.0 ? SafetyFault::kTorque : SafetyFault::kNone);
    }
  }
}

// Brings a supervised arm into kHold, by a joint that is too fast.
void too_fast(Supervised& s) {
  s.dq_[0] = 2.1;
  s.run();
  EXPECT_EQ(s.safety_.fault(), SafetyFault::kVelocity);
  EXPECT_EQ(s.safety_.action(), SafetyAction::kHold);
}

// The test of hold: the energy falls to a half within held_seconds, or the motors go off.
TEST(SafetySupervisor, AHeldArmComesToRestOrIsSwitchedOff) {
  for (const bool by_controller : {false, true}) {
    for (const double half_life : {0.08, 1.0}) {  // [s] of the energy
      Supervised s;
      if (by_controller) {
        s.input_.held = true;
      } else {
        too_fast(s);
      }
      s.dq_[0] = 1.9;
      for (int k = 0; k < 80; ++k) {
        s.dq_[0] *= std::pow(0.5, 0.5 * 1e-3 / half_life);
        s.run();
        EXPECT_NE(s.safety_.fault(), SafetyFault::kNotHeld) << k;
      }
      for (int k = 0; k < 320; ++k) {
        s.dq_[0] *= std::pow(0.5, 0.5 * 1e-3 / half_life);
        s.run();
        // It is found in time.
        if (half_life == 1.0 && k >= 40) {
          EXPECT_EQ(s.safety_.fault(), SafetyFault::kNotHeld) << k;
        }
      }
      const bool slows = half_life < 0.1;
      EXPECT_EQ(s.safety_.fault() == SafetyFault::kNotHeld, !slows) << by_controller;
      EXPECT_EQ(s.safety_.action() == SafetyAction::kMotorsOff, !slows);
      EXPECT_EQ(s.run().norm() == 0.0, !slows);
    }
  }
  // An arm that moves because it is told to is not held.
  Supervised s;
  s.dq_[0] = 1.9;
  for (int k = 0; k < 400; ++k) s.run();
  EXPECT_EQ(s.safety_.fault(), SafetyFault::kNone);
}

TEST(SafetySupervisor, ARunawayArmAfterAFaultIsSwitchedOffAtOnce) {
  Supervised s;
  too_fast(s);
  s.dq_[0] = 2.9;
  s.run();
  EXPECT_EQ(s.safety_.action(), SafetyAction::kHold);
  s.dq_[0] = 3.1;
  EXPECT_EQ(s.run().norm(), 0.0);
  EXPECT_EQ(s.safety_.fault(), SafetyFault::kNotHeld);
  EXPECT_EQ(s.safety_.joint(), JointIndex{0});
}

TEST(SafetySupervisor, ALaterFaultChangesTheActionOnlyToAStrongerOne) {
  Supervised s;
  too_fast(s);
  s.dq_.setZero();
  s.input_.force_age = 1.0;  // forces are not needed to brake
  s.run();
  EXPECT_EQ(s.safety_.action(), SafetyAction::kHold);
  s.input_.force_age = 0.0;
  s.input_.force << 0, 0, 16;
  s.run();
  EXPECT_EQ(s.safety_.action(), SafetyAction::kRelease);
  s.input_.force.setZero();
  s.run();
  s.q_[0] += 0.05;
  s.run();
  EXPECT_EQ(s.safety_.action(), SafetyAction::kFreeze);
  s.input_.force << 0, 0, 16;
  s.run();
  EXPECT_EQ(s.safety_.action(), SafetyAction::kFreeze);
  ASSERT_EQ(s.safety_.events(), 4);
  EXPECT_EQ(s.safety_.event(0).fault, SafetyFault::kVelocity);
  EXPECT_EQ(s.safety_.event(1).fault, SafetyFault::kForceSensor);
  EXPECT_EQ(s.safety_.event(2).fault, SafetyFault::kForce);
  EXPECT_EQ(s.safety_.event(3).fault, SafetyFault::kEncoderJump);
  EXPECT_NEAR(s.safety_.event(3).after, 0.004, 1e-9);
  EXPECT_TRUE(s.safety_.reset());
  EXPECT_EQ(s.safety_.events(), 0);
}

// What holds beside the model is no more than the model may be wrong by and the measured force takes.
TEST(SafetySupervisor, AHoldingTorqueStaysWithinTheModelUncertainty) {
  for (const bool pulled : {false, true}) {
    for (const double sign : {-1.0, 1.0}) {
      Supervised s;
      if (pulled) s.input_.force << 0, 8, 0;
      s.input_.force_expected.setConstant(NAN);
      s.safety_.set_holding_torque(Eigen::Vector3d::Constant(sign * 25.0));
      s.run();
      s.input_.dt = 0.02;
      s.run();
      ASSERT_EQ(s.safety_.fault(), SafetyFault::kOverrun);
      s.safety_.set_holding_torque(Eigen::Vector3d::Constant(9.0));  // too late
      s.input_.dt = 0.001;
      const VectorXd out = s.run();
      TorqueUncertainty uncertainty(s.arm_);
      VectorXd u = uncertainty.update(s.state_, VectorXd::Zero(3));
      const VectorXd load =
          s.state_.tip().jacobian().topRows<3>().transpose() * s.input_.force;
      for (int i = 0; i < 3; ++i) {
        const double most = u[i] + std::max(0.0, sign * load[i]);
        const double wanted = s.state_.bias()[i] + sign * std::min(25.0, most);
        EXPECT_NEAR(out[i], std::clamp(wanted, -kTorque, kTorque), 1e-9) << i;
      }
    }
  }
}

TEST(SafetySupervisor, BrakesAgainstTheMotion) {
  Supervised s;
  s.safety_.set_holding_torque(Eigen::Vector3d(0.01, 0.02, -0.01));
  s.run();
  s.dq_ << 0.3, -0.2, 0.05;
  s.input_.dt = 0.02;
  VectorXd out = s.run();
  VectorXd wanted = s.state_.bias() - 30.0 * s.state_.mass_matrix() * s.dq_;
  wanted += Eigen::Vector3d(0.01, 0.02, -0.01);
  EXPECT_TRUE(near(out, wanted.cwiseMin(kTorque).cwiseMax(-kTorque), 1e-9));
  s.input_.dt = 0.001;
  s.input_.force << 0, 16, 0;
  out = s.run();
  wanted = s.state_.bias() - 30.0 * s.state_.mass_matrix() * s.dq_;
  EXPECT_EQ(s.safety_.action(), SafetyAction::kRelease);
  EXPECT_TRUE(near(out, wanted.cwiseMin(kTorque).cwiseMax(-kTorque), 1e-9));
}

TEST(SafetySupervisor, NeverExceedsTheMotorLimits) {
  Supervised s;
  s.tau_ << 50, -50, 31;
  EXPECT_TRUE(near(s.run(), Eigen::Vector3d(30, -30, 30), 0.0));
}

TEST(SafetySupervisor, AnArmWithoutValidSamplesGetsNoTorque) {
  Supervised s;
  s.safety_.disable();
  EXPECT_TRUE(s.safety_.enable());
  EXPECT_TRUE(s.safety_.activate());
  s.q_.setConstant(NAN);
  EXPECT_EQ(s.run().norm(), 0.0);
  EXPECT_EQ(s.safety_.fault(), SafetyFault::kNotFinite);
  EXPECT_EQ(s.safety_.action(), SafetyAction::kMotorsOff);
}

// Numbers that are none, or too large to be computed with, come out as torques that are finite.
TEST(SafetySupervisor, HoldingTorquesAreFiniteForAnyInput) {
  for (const double dt : {0.0, -1.0, static_cast<double>(NAN)}) {
    Supervised s;
    s.safety_.set_holding_torque(Eigen::Vector3d(NAN, 0.01, INFINITY));
    s.dq_ << 0.5, -0.3, 0.1;
    s.run();
    s.q_.setConstant(NAN);
    s.input_.dt = dt;
    const VectorXd first = s.run();
    for (int k = 0; k < 1000; ++k) ASSERT_TRUE(s.run().allFinite()) << dt;
    // What brakes decays; what holds is the weight and the one torque that was a number.
    GravityCompensation gravity(s.arm_);
    const VectorXd holds = gravity.update(Eigen::Vector3d(0.1, 0.2, 0.1)) + Eigen::Vector3d(0, 0.01, 0);
    EXPECT_TRUE(near(s.run(), holds, 1e-6)) << dt;
    EXPECT_GT((first - holds).norm(), 0.1) << dt;
    s.safety_.disable();  // a fault remains
    EXPECT_EQ(s.safety_.state(), SafetyState::kFault);
  }
  Supervised far;
  far.safety_.disable();
  EXPECT_TRUE(far.safety_.enable());
  far.q_ << 0.1, 0.2, 1e200;  // the first position that is seen, whose square is infinite
  EXPECT_TRUE(far.run().allFinite());
}

// A robot file's effort limits count where there are any; without a range a joint has a fixed bound.
TEST(SafetySupervisor, LimitsComeFromTheRobotFileOrHaveDefaults) {
  ModelDescription d = plausible_model(read_model("psm-3dof"), 1).arm.description();
  d.coordinates[0].limits.effort = 7.0;
  for (const int i : {1, 2}) d.coordinates[i].limits.upper = std::numeric_limits<double>::infinity();
  const SafetyLimits limits = safety_limits(Model(std::move(d)), kTorque);
  EXPECT_EQ(limits.torque, Eigen::Vector3d(7.0, kTorque, kTorque));
  EXPECT_NEAR(limits.tracking[0], 0.05 * (limits.upper[0] - limits.lower[0]), 1e-12);
  EXPECT_EQ(limits.tracking[1], 0.1);
  EXPECT_EQ(limits.tracking[2], 0.02);
}

TEST(SafetySupervisor, BadLimitsAreRefused) {
  const Model arm = plausible_model(read_model("psm-3dof"), 1).arm;
  SafetyLimits limits = safety_limits(arm, kTorque);
  limits.torque[1] = std::numeric_limits<double>::infinity();
  EXPECT_THROW(SafetySupervisor(arm, limits), InvalidInput);
  limits = safety_limits(arm, kTorque);
  limits.upper[0] = limits.lower[0];
  EXPECT_THROW(SafetySupervisor(arm, limits), InvalidInput);
  limits = safety_limits(arm, kTorque);
  limits.velocity.resize(2);
  EXPECT_THROW(SafetySupervisor(arm, limits), InvalidInput);
  limits = safety_limits(arm, kTorque);
  limits.force = 0.0;
  EXPECT_THROW(SafetySupervisor(arm, limits), InvalidInput);
}

}  // namespace
}  // namespace veridyn
