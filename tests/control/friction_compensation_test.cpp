#include <gtest/gtest.h>

#include <limits>

#include "control/arm_rig.hpp"
#include "control/control_support.hpp"
#include "veridyn/control/adaptive_friction.hpp"
#include "veridyn/control/computed_torque.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/model_error_observer.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn {
namespace {

constexpr double kViscous = 0.7;
constexpr double kCoulomb = 1.0;

// The insertion of the thesis: about 1 N of Coulomb friction.
Model thesis_friction() {
  const Model arm = plausible_model(read_model("psm-3dof"), 1).arm;
  return with_effects(arm, {effect_on(arm, "viscous_friction", 2, {{"coefficient", kViscous}}),
                            effect_on(arm, "coulomb_friction", 2, {{"level", kCoulomb}})});
}

FrictionOptions rule(FrictionRule which) {
  FrictionOptions options;
  options.rule = which;
  options.share = 1.0;
  return options;
}

struct Asked {
  double v, v_wanted, error;
};

double torque(FrictionCompensation& friction, ArmState& state, const Asked& asked) {
  const VectorXd q = Eigen::Vector3d(0.1, 0.2, 0.1);
  state.update(q, Eigen::Vector3d(0, 0, asked.v));
  friction.reset();
  return friction.update(state, Eigen::Vector3d(0, 0, asked.v_wanted),
                         Eigen::Vector3d(0, 0, asked.error), kPeriod)[2];
}

// Listing 7.5.1 with the errata, in numbers: velocity deadband 5 mm/s, position deadband 0.3 mm,
// Fs = the Coulomb level.
TEST(FrictionCompensation, TheStickSlipRuleHasTheValuesOfTheThesisWithErrata) {
  const Model arm = thesis_friction();
  ArmState state(arm, {"tool"});
  FrictionCompensation stick(arm, rule(FrictionRule::kStickSlip));
  FrictionCompensation plain(arm, rule(FrictionRule::kVelocity));
  const double whole = 1e-9;
  for (const double side : {1.0, -1.0}) {
    // Outside the deadband: viscous and Coulomb friction of the velocity.
    EXPECT_NEAR(torque(stick, state, {side * 0.02, 0, 0}), side * (kCoulomb + kViscous * 0.02),
                whole);
    // A wanted velocity that is faster replaces it, in both directions; a slower or opposite one
    // does not.
    EXPECT_NEAR(torque(stick, state, {side * 0.02, side * 0.05, 0}),
                side * (kCoulomb + kViscous * 0.05), whole);
    EXPECT_NEAR(torque(stick, state, {side * 0.02, -side * 0.05, 0}),
                side * (kCoulomb + kViscous * 0.02), whole);
    // Inside it: friction at rest in the direction of the error, once that leaves its deadband.
    EXPECT_NEAR(torque(stick, state, {side * 0.004, 0, side * 0.0004}), side * kCoulomb, 1e-3);
    EXPECT_NEAR(torque(stick, state, {-side * 0.004, 0, side * 0.0004}), side * kCoulomb, 1e-3);
    EXPECT_EQ(torque(stick, state, {side * 0.004, 0, side * 0.0002}), 0.0);
    // Without the rule nothing acts inside the deadband (the listing added half the Coulomb force).
    EXPECT_EQ(torque(plain, state, {side * 0.004, 0, side * 0.0004}), 0.0);
    EXPECT_NEAR(torque(plain, state, {side * 0.02, 0, 0}), side * (kCoulomb + kViscous * 0.02),
                whole);
  }
}

// Where a rule asks for sliding, a memory is sheared in the direction of the motion.
TEST(FrictionCompensation, PreslidingHysteresisInFullSlidingEqualsCoulombFriction) {
  const Model arm = thesis_friction();
  const Model with_memory =
      with_effects(arm, {effect_on(arm, "presliding_hysteresis", 2, {{"level", kCoulomb}, {"distance", 1e-3}})});
  ArmState state(with_memory, {"tool"});
  FrictionCompensation friction(with_memory, rule(FrictionRule::kStickSlip));
  for (const double side : {1.0, -1.0}) {
    EXPECT_NEAR(torque(friction, state, {side * 0.02, 0, 0}), side * kCoulomb, 1e-9);
    EXPECT_NEAR(torque(friction, state, {0, 0, side * 0.0004}), side * kCoulomb, 1e-9);
  }
}

// A share of the load is the same torque in whatever unit an axis s = c q is counted: the load along it is
// tau / c, and the friction force along it c times that on the joint.
TEST(FrictionCompensation, LoadDependentFrictionDoesNotDependOnTheUnitOfItsAxis) {
  const Model arm = plausible_model(read_model("psm-3dof"), 1).arm;
  const double share = 0.1;
  for (const double c : {1.0, 2.0, -0.5}) {
    EffectTerm term = effect_on(arm, "load_dependent_friction", 2, {{"coefficient", share}});
    term.axis.coefficients *= c;
    const Model loaded = with_effects(arm, {term});
    ArmState state(loaded, {"tool"});
    FrictionCompensation friction(loaded, rule(FrictionRule::kVelocity));
    const double found = torque(friction, state, {0.1, 0, 0});
    EXPECT_GT(found, 0.01) << c;
    EXPECT_NEAR(found, share * std::abs(state.rigid_bias()[2]), 1e-9) << c;
  }
}

// At rest the presliding rule gives what the contact holds, and after a reversal it follows
// z = 1 - 2 (1 - exp(-way / distance)).
TEST(FrictionCompensation, ThePreslidingRuleFollowsTheExponentialOfTheHysteresis) {
  Model arm = thesis_friction();
  const double distance = 1e-3;
  arm = with_effects(
      arm, {effect_on(arm, "presliding_hysteresis", 2, {{"level", 0.5}, {"distance", distance}})});
  ArmState state(arm, {"tool"});
  FrictionOptions options = rule(FrictionRule::kPresliding);
  options.tank_capacity.prismatic = std::numeric_limits<double>::infinity();
  FrictionCompensation friction(arm, options);
  const VectorXd none = VectorXd::Zero(3);
  const auto at = [&](double insertion) {
    state.update(Eigen::Vector3d(0, 0, insertion), none);
    return friction.update(state, none, none, kPeriod)[2];
  };
  double s = 0.1;
  EXPECT_EQ(at(s), 0.0);
  for (; s < 0.12; s += 1e-4) at(s);
  EXPECT_NEAR(at(s), 0.5, 1e-6);
  EXPECT_NEAR(at(s), 0.5, 1e-6);  // at rest it stays
  EXPECT_NEAR(at(s - 0.4e-3), 0.5 * (1.0 - 2.0 * (1.0 - std::exp(-0.4))), 1e-6);
  friction.reset();
  EXPECT_EQ(at(s), 0.0);
}

// The stronger the compensation, the more a joint that is pushed through its work moves; the store
// bounds the energy: after any reference has stopped, compensation has given at most one reserve.
TEST(FrictionCompensation, TheEnergyTankBoundsTheEnergyOfCompensation) {
  const Model arm = thesis_friction();
  ArmState state(arm, {"tool"});
  FrictionCompensation friction(arm, rule(FrictionRule::kVelocity));
  const VectorXd none = VectorXd::Zero(3);
  Random random(4);
  double s = 0.12;
  double work = 0.0;
  double force = 0.0;
  for (int k = 0; k < 20000; ++k) {
    const double v = 0.1 * std::sin(1e-3 * k * (1.0 + random.in(0, 1e-4)));
    s += v * kPeriod;
    work += force * v * kPeriod;
    state.update(Eigen::Vector3d(0, 0, s), Eigen::Vector3d(0, 0, v));
    force = friction.update(state, none, none, kPeriod)[2];
    EXPECT_GE(friction.tank_level(0), 0.0);
  }
  EXPECT_LE(work, kCoulomb * 0.002 * 1.05);
  EXPECT_GT(work, kCoulomb * 0.002 * 0.5);
  // A wanted motion fills it again.
  state.update(Eigen::Vector3d(0, 0, s), Eigen::Vector3d(0, 0, 0.0));
  for (int k = 0; k < 100; ++k) friction.update(state, Eigen::Vector3d(0, 0, 0.1), none, kPeriod);
  EXPECT_NEAR(friction.tank_level(0), 1.0, 1e-9);
}

// Friction at rest is 1 N at 0.1 m and 2 N at 0.2 m: what fills the tank here is half of it there.
TEST(FrictionCompensation, TheTankLevelIsRelativeToTheFrictionAtThePosition) {
  const Model arm = plausible_model(read_model("psm-3dof"), 1).arm;
  const Model varying = with_effects(
      arm, {effect_on(arm, "coulomb_friction", 2, {{"level", kCoulomb}}),
            effect_on(arm, "position_dependent_friction", 2, {{"slope", 10.0}, {"curvature", 0.0}, {"centre", 0.1}})});
  ArmState state(varying, {"tool"});
  FrictionCompensation friction(varying, rule(FrictionRule::kVelocity));
  const VectorXd none = VectorXd::Zero(3);
  for (const double s : {0.1, 0.2}) {
    state.update(Eigen::Vector3d(0, 0, s), none);
    friction.update(state, none, none, kPeriod);
    EXPECT_NEAR(friction.tank_level(0), 0.1 / s, 1e-9);
  }
}

struct Excursion {
  double late;  ///< how far the joints still move in the last two of ten seconds, in deadbands
  double most;  ///< largest distance from the start, in deadbands
};

// A push while everything should stand still; the real friction is 80 % of the identified.
Excursion after_a_push(FrictionRule which, double share, bool supervised, bool with_feedback) {
  const Model model = plausible_model(read_model("psm-3dof"), 1).arm;
  ArmRig rig(with_scaled_friction(model, 0.8), {"tool"});
  ArmState state(model, {"tool"});
  FrictionOptions options = rule(which);
  options.share = share;
  if (!supervised)
    options.tank_capacity.revolute = options.tank_capacity.prismatic = std::numeric_limits<double>::infinity();
  FrictionCompensation friction(model, options);
  JointGains gains{Eigen::Vector3d(25, 20, 75), Eigen::Vector3d(10, 11, 15)};
  if (!with_feedback) gains.p = gains.d = VectorXd::Zero(3);
  ComputedTorque control(3, gains);
  const VectorXd start = Eigen::Vector3d(0.1, 0.05, 0.12);
  const VectorXd deadband = Eigen::Vector3d(0.0015, 0.0015, 0.0003);
  rig.place(start);
  JointReference wanted(3);
  wanted.q = start;
  VectorXd tau(3);
  VectorXd low = VectorXd::Constant(3, 1e9);
  VectorXd high = -low;
  Excursion out{0, 0};
  for (int k = 0; k < 10000; ++k) {
    state.update(rig.q(), rig.dq());
    if (!with_feedback) wanted.q = rig.q();
    tau = control.update(state, wanted);
    tau += friction.update(state, wanted.dq, wanted.q - rig.q(), kPeriod);
    if (k >= 100 && k < 300) tau += Eigen::Vector3d(1.0, 0.8, 2.0);
    if (rig.cycle(tau) != StepStatus::kOk) return {1e9, 1e9};
    out.most = std::max(out.most,
                        (rig.engine().q() - start).cwiseQuotient(deadband).cwiseAbs().maxCoeff());
    if (k < 8000) continue;
    low = low.cwiseMin(rig.engine().q());
    high = high.cwiseMax(rig.engine().q());
  }
  out.late = (high - low).cwiseQuotient(deadband).maxCoeff();
  return out;
}

TEST(FrictionCompensation, TheArmComesToRestIfFrictionIsFourFifthsOfTheModels) {
  for (const FrictionRule which :
       {FrictionRule::kVelocity, FrictionRule::kStickSlip, FrictionRule::kPresliding}) {
    for (const bool with_feedback : {true, false}) {
      for (const double share : {0.8, 1.0}) {
        const Excursion moved = after_a_push(which, share, true, with_feedback);
        EXPECT_LT(moved.late, 0.01) << static_cast<int>(which) << with_feedback << share;
      }
    }
  }
}

// What the supervision is for: without it the rule of the thesis keeps the arm moving.
TEST(FrictionCompensation, WithoutTheEnergyTankTheArmKeepsMovingAfterAPush) {
  EXPECT_GT(after_a_push(FrictionRule::kStickSlip, 1.0, false, true).late, 3.0);
  EXPECT_GT(after_a_push(FrictionRule::kStickSlip, 1.0, false, false).late, 100.0);
}

// A time that is none empties the tank, which is safe; reset() fills it at once.
TEST(FrictionCompensation, ANonFiniteTimeEmptiesTheTank) {
  const Model arm = thesis_friction();
  ArmState state(arm, {"tool"});
  FrictionCompensation friction(arm, rule(FrictionRule::kVelocity));
  const VectorXd none = VectorXd::Zero(3);
  state.update(Eigen::Vector3d(0.1, 0.2, 0.1), Eigen::Vector3d(0, 0, 0.1));
  EXPECT_GT(friction.update(state, none, none, kPeriod)[2], kCoulomb);
  EXPECT_EQ(friction.update(state, none, none, NAN).norm(), 0.0);
  EXPECT_EQ(friction.tank_level(0), 0.0);
  friction.reset();
  EXPECT_EQ(friction.tank_level(0), 1.0);
  EXPECT_GT(friction.update(state, none, none, kPeriod)[2], kCoulomb);
  FrictionOptions nothing = rule(FrictionRule::kVelocity);
  nothing.share = 0.0;
  FrictionCompensation without(arm, nothing);
  for (int k = 0; k < 2; ++k) EXPECT_EQ(without.update(state, none, none, kPeriod).norm(), 0.0);
  EXPECT_EQ(without.tank_level(0), 1.0);  // of a tank that holds nothing
}

// Terms along one direction that count from different places are different frictions.
TEST(FrictionCompensation, TermsWithDifferentAxisOffsetsAreSeparateAxes) {
  const Model arm = plausible_model(read_model("psm-3dof"), 1).arm;
  EffectTerm here = effect_on(arm, "coulomb_friction", 2, {{"level", 1.0}}), there = here;
  there.axis.offset = 0.05;
  EXPECT_EQ(FrictionCompensation(with_effects(arm, {here, here})).axes(), 1);
  EXPECT_EQ(FrictionCompensation(with_effects(arm, {here, there})).axes(), 2);
}

TEST(FrictionCompensation, InvalidOptionsAreRefused) {
  const Model arm = thesis_friction();
  EXPECT_THROW(FrictionCompensation(with_effects(arm, {effect_on(arm, "coulomb_friction", 0, {})})),
               InvalidInput);
  FrictionOptions options;
  options.share = -0.1;
  EXPECT_THROW(FrictionCompensation(arm, options), InvalidInput);
  options.share = 1.0;
  options.position.prismatic = 0.0;
  EXPECT_THROW(FrictionCompensation(arm, options), InvalidInput);
  FrictionCompensation friction(arm);
  EXPECT_FALSE(friction.set_scale(0, 3.0));
  EXPECT_FALSE(friction.set_scale(7, 1.0));
  EXPECT_TRUE(friction.set_scale(0, 0.5));
}

// Friction that is 70 % of the identified, gravity that is wrong: the share finds 0.7 and no more,
// stays within its bounds, and does nothing unless it is switched on.
double learned_share(double real_share, const AdaptiveFrictionOptions& options) {
  const Model model = plausible_model(read_model("psm-3dof"), 1).arm;
  ArmRig rig(with_scaled_friction(model, real_share), {"tool"});
  const Model wrong = [&] {
    ModelDescription d = model.description();
    for (Frame& frame : d.frames) {
      if (frame.body) *frame.body->phi *= 1.03;
    }
    return Model(std::move(d));
  }();
  ArmState state(wrong, {"tool"});
  FrictionCompensation friction(wrong);
  AdaptiveFriction adaptive(friction, options);
  ModelErrorOptions error_options;
  error_options.limit = VectorXd::Constant(3, 5.0);
  ModelErrorObserver error(3, error_options);
  ComputedTorque control(3, {Eigen::Vector3d(25, 20, 75), Eigen::Vector3d(10, 11, 15)});
  JointReference wanted(3);
  const Eigen::Vector3d middle(0.1, 0.05, 0.12);
  const Eigen::Vector3d reach(0.5, 0.4, 0.08);
  rig.place(middle);
  VectorXd tau(3);
  for (int k = 0; k < 40000; ++k) {
    const double t = kPeriod * k;
    const double w = 0.8;
    const double in = std::min(1.0, t / 4.0);
    wanted.q = middle + in * reach * std::sin(w * t);
    wanted.dq = in * reach * w * std::cos(w * t);
    wanted.ddq = -in * reach * w * w * std::sin(w * t);
    state.update(rig.q(), rig.dq());
    tau = control.update(state, wanted);
    tau += friction.update(state, wanted.dq, wanted.q - rig.q(), kPeriod);
    tau += error.update(state, control.acceleration(), kPeriod);
    adaptive.update(state, error.missing(), kPeriod, friction);
    EXPECT_EQ(rig.cycle(tau), StepStatus::kOk);
  }
  return adaptive.share(2);
}

TEST(AdaptiveFriction, ConvergesToTheTrueFrictionWithinItsBounds) {
  AdaptiveFrictionOptions options;
  EXPECT_EQ(learned_share(0.7, options), FrictionOptions().share);
  options.enabled = true;
  EXPECT_NEAR(learned_share(0.7, options), 0.7, 0.06);
  EXPECT_NEAR(learned_share(1.2, options), 1.2, 0.06);
  options.least = 0.5;
  EXPECT_NEAR(learned_share(0.2, options), 0.5, 0.01);
  options.least = 1.1;
  const FrictionCompensation friction(thesis_friction());
  EXPECT_THROW(AdaptiveFriction(friction, options), InvalidInput);
}

}  // namespace
}  // namespace veridyn
