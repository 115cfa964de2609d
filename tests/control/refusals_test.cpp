#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <string>

#include "control/control_support.hpp"
#include "control/refusals.hpp"
#include "veridyn/control/adaptive_friction.hpp"
#include "veridyn/control/computed_torque.hpp"
#include "veridyn/control/cooperative_controller.hpp"
#include "veridyn/control/impedance.hpp"
#include "veridyn/control/model_error_observer.hpp"
#include "veridyn/control/momentum_observer.hpp"
#include "veridyn/control/object_impedance.hpp"
#include "veridyn/control/quintic_interpolator.hpp"
#include "veridyn/control/safety_supervisor.hpp"
#include "veridyn/control/teleoperation.hpp"
#include "veridyn/control/tether_guard.hpp"
#include "veridyn/control/velocity_observer.hpp"
#include "veridyn/math/require.hpp"

// What constructors refuse: each class gets options that it takes, and then one of them wrong at a time.

namespace veridyn {
namespace {

const Model& three_joints() {
  return sample_arms().at("spherical_RRP");
}

TEST(Refusals, ComputedTorqueRejectsInvalidOptions) {
  using O = JointGains;
  refuses<O>({VectorXd::Ones(3), VectorXd::Zero(3)},
             {[](O& o) { o.p.resize(2); }, [](O& o) { o.d = VectorXd::Ones(4); }, [](O& o) { o.p[1] = kNone; },
              [](O& o) { o.d[2] = kEndless; }, [](O& o) { o.p[2] = -1.0; }},
             [](const O& o) { ComputedTorque(3, o); });
}

TEST(Refusals, ImpedanceRejectsInvalidOptions) {
  using O = ImpedanceGains;
  const Wrongs<O> wrongs = {[](O& o) { o.mass[5] = 0.0; },       [](O& o) { o.mass[0] = kEndless; },
                            [](O& o) { o.damping[3] = -1.0; },   [](O& o) { o.damping[1] = kNone; },
                            [](O& o) { o.stiffness[2] = -1.0; }, [](O& o) { o.stiffness[4] = kNone; }};
  const Model& arm = three_joints();
  refuses<O>({}, wrongs, [&](const O& o) { Impedance(arm, {last_frame(arm)}, o); });
  Impedance control(arm, {last_frame(arm)}, {});
  for (const auto& wrong : wrongs) {
    O gains;
    wrong(gains);
    EXPECT_FALSE(control.set_gains(gains));
  }
  O stiff;
  stiff.stiffness[0] = 5.0;
  EXPECT_TRUE(control.set_gains(stiff));
  EXPECT_EQ(control.gains().stiffness[0], 5.0);

  using P = ImpedanceOptions;
  P good;
  good.posture = VectorXd::Zero(3);
  refuses<P>(good,
             each<P>({&P::posture_p, &P::posture_d}, {-1.0, kNone}) +
                 Wrongs<P>{[](P& o) { o.posture[1] = kNone; }, [](P& o) { o.home(1, 1) = kNone; },
                           [](P& o) { o.home(0, 0) = -1.0; },  // a mirror
                           [](P& o) { o.inverse.length = -1.0; }, [](P& o) { o.inverse.length = kEndless; },
                           [](P& o) { o.inverse.threshold = 0.0; }, [](P& o) { o.inverse.threshold = kEndless; }},
             [&](const P& o) { Impedance(arm, {last_frame(arm)}, {}, o); });
}

TEST(Refusals, ObserversRejectInvalidOptions) {
  const Model& arm = three_joints();
  using E = ModelErrorOptions;
  const VectorXd limit = VectorXd::Ones(3);
  refuses<E>({10.0, limit},
             each<E>({&E::bandwidth}, {-1.0, kEndless, kNone}) +
                 Wrongs<E>{[](E& o) { o.limit[1] = kEndless; }, [](E& o) { o.limit[2] = -1.0; }},
             [](const E& o) { ModelErrorObserver(3, o); });
  EXPECT_FALSE(ModelErrorObserver(3, {10.0, limit}).set_limit(-limit));
  using M = MomentumObserverOptions;
  refuses<M>({}, each<M>({&M::bandwidth}, {-1.0, kEndless, kNone}) + Wrongs<M>{[](M& o) { o.cycles = 0; }},
             [&](const M& o) { MomentumObserver(arm, {last_frame(arm)}, o); });
  using U = UncertaintyOptions;
  refuses<U>({},
             each<U>({&U::relative, &U::deviations}, {0.0, kNone}) +
                 Wrongs<U>{[](U& o) { o.velocity.revolute = 0.0; }, [](U& o) { o.velocity.prismatic = kNone; }},
             [&](const U& o) { TorqueUncertainty(arm, o); });
  for (const double wrong : {-1.0, kEndless, kNone}) EXPECT_THROW(VelocityObserver(1, wrong), InvalidInput);
  for (const double wrong : {kEndless, kNone})
    EXPECT_THROW(QuinticInterpolator(VectorXd::Constant(2, wrong)), InvalidInput);
}

TEST(Refusals, FrictionCompensationRejectsInvalidOptions) {
  const Model& bare = three_joints();
  const Model arm = with_effects(bare, {effect_on(bare, "coulomb_friction", 0, {{"level", 0.1}})});
  using F = FrictionOptions;
  Wrongs<F> wrongs = each<F>({&F::share}, {-0.1, 2.1, kNone});
  for (const auto deadband : {&F::velocity, &F::position, &F::tank_capacity})
    for (const auto of : {&Deadband::revolute, &Deadband::prismatic})
      for (const double value : {0.0, kNone}) wrongs.push_back([=](F& o) { o.*deadband.*of = value; });
  refuses<F>({}, wrongs, [&](const F& o) { FrictionCompensation(arm, o); });
  FrictionCompensation friction(arm);
  EXPECT_FALSE(friction.set_scale(-1, 1.0) || friction.set_scale(0, -0.1) || friction.set_scale(0, kNone));
  EXPECT_EQ(friction.scale(0), 1.0);
  using A = AdaptiveFrictionOptions;
  refuses<A>({},
             each<A>({&A::least}, {-0.1, 0.9, kNone}) + each<A>({&A::most}, {0.7, 2.1, kNone}) +
                 each<A>({&A::rate}, {-1.0, kEndless, kNone}),
             [&](const A& o) { AdaptiveFriction(friction, o); });
}

TEST(Refusals, ForceLawAndTeleoperationRejectInvalidOptions) {
  using L = ForceLaw;
  refuses<L>({},
             each<L>({&L::deadband, &L::increment, &L::gain, &L::proportional, &L::damping, &L::feed_forward,
                      &L::reach, &L::stiffness},
                     {-1.0, kEndless, kNone}),
             [](const L& law) { ForceTracker tracker(law); });
  EXPECT_THROW(tuned_force_law(300.0, 0.0, 30.0), InvalidInput);
  EXPECT_THROW(tuned_force_law(300.0, 300.0, -1.0), InvalidInput);
  const Eigen::Vector3d here = Eigen::Vector3d::Zero(), nowhere(0.0, kNone, 0.0);
  using T = TeleoperationOptions;
  refuses<T>({},
             each<T>({&T::scale, &T::largest_force, &T::speed, &T::cutoff, &T::ramp, &T::period},
                     {0.0, kEndless, kNone}) +
                 each<T>({&T::force_scale, &T::damping}, {-1.0, kEndless, kNone}) +
                 Wrongs<T>{[](T& o) { o.R_follower_leader *= 2.0; }, [](T& o) { o.R_follower_leader *= -1.0; },
                           [](T& o) { o.R_follower_leader(2, 1) = kNone; }},
             [&](const T& o) { Teleoperation(o, here, here); });
  EXPECT_THROW(Teleoperation({}, nowhere, here), InvalidInput);
  EXPECT_THROW(Teleoperation({}, here, nowhere), InvalidInput);
}

TEST(Refusals, ObjectImpedanceRejectsInvalidOptions) {
  using O = ObjectImpedanceOptions;
  O good;
  good.grasps = {Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX()};
  refuses<O>(good,
             each<O>({&O::mass, &O::damping, &O::stiffness, &O::angular_damping, &O::angular_stiffness},
                     {-1.0, kEndless, kNone}) +
                 each<O>({&O::wanted_mass, &O::wanted_inertia}, {0.0, kNone}) +
                 Wrongs<O>{[](O& o) { o.grasps[1].y() = kNone; }, [](O& o) { o.inertia.x() = -1.0; },
                           [](O& o) { o.inertia.y() = kEndless; }, [](O& o) { o.inertia.z() = kNone; },
                           [](O& o) { o.gravity.x() = kNone; }},
             [](const O& o) { ObjectImpedance control(o); });
}

TEST(Refusals, TetherGuardAndCooperativeControllerRejectInvalidOptions) {
  using G = TetherGuardOptions;
  refuses<G>({},
             each<G>({&G::period, &G::margin, &G::horizon, &G::least_push, &G::rest, &G::acceleration, &G::speed,
                      &G::smoothing},
                     {0.0, kEndless, kNone}),
             [](const G& o) { TetherGuard(2, {{0, 1, 1.0}}, o); });
  for (const auto& [from, to] : {std::pair{-1, 0}, {2, 0}, {0, -1}, {0, 2}, {1, 1}})
    EXPECT_THROW(TetherGuard(2, {{from, to, 1.0}}, {}), InvalidInput);

  using O = CooperativeOptions;
  O good;
  good.R_world_arm.assign(2, Eigen::Matrix3d::Identity());
  good.members = {{0, 1, {}, 1.0}};
  const std::vector<Eigen::Vector3d> tips{Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX()};
  Wrongs<O> wrongs =
      each<O>({&O::period, &O::largest_force, &O::largest_force_error, &O::largest_age, &O::largest_error,
               &O::stuck_force, &O::jump_force, &O::drift_force, &O::drift_length, &O::drift_way,
               &O::stop_duration, &O::relief_force, &O::relief_gain, &O::relief_speed},
              {0.0, kEndless, kNone}) +
      each<O>({&O::drift_factor}, {0.9, kNone}) + each<O>({&O::largest_energy}, {0.0, kNone});
  for (const int none : {-1, 2}) {
    wrongs.push_back([=](O& o) { o.leader = none; });
    wrongs.push_back([=](O& o) { o.members[0].from = none; });
    wrongs.push_back([=](O& o) { o.members[0].to = none; });
  }
  for (const double share : {0.0, 1.1, kNone}) wrongs.push_back([=](O& o) { o.members[0].share = share; });
  wrongs.push_back([](O& o) { o.R_world_arm[1] *= 0.5; });
  wrongs.push_back([](O& o) { o.R_world_arm[1].col(2) *= -1.0; });
  wrongs.push_back([](O& o) { o.R_world_arm[1](0, 1) = kNone; });
  refuses<O>(good, wrongs, [&](const O& o) { CooperativeController(o, tips); });
  EXPECT_THROW(CooperativeController({}, {}), InvalidInput);
  EXPECT_THROW(CooperativeController(good, {tips[0], Eigen::Vector3d(0.0, kNone, 0.0)}), InvalidInput);
}

TEST(Refusals, SafetySupervisorRejectsInvalidOptions) {
  using L = SafetyLimits;
  const Model& arm = three_joints();
  L good = safety_limits(arm, 30.0);
  good.lower.setConstant(-1.0);
  good.upper.setConstant(1.0);
  for (VectorXd L::*v : {&L::velocity, &L::torque, &L::tracking}) (good.*v).setOnes();
  Wrongs<L> wrongs =
      each<L>({&L::force, &L::force_disagreement, &L::disagreement_seconds, &L::sensor_age, &L::force_age,
               &L::overrun, &L::torque_seconds, &L::homing_share, &L::braking, &L::held_seconds, &L::rest_share,
               &L::runaway, &L::model_error},
              {0.0, kNone}) +
      each<L>({&L::braking}, {kEndless});
  // A number that is none may stand anywhere: a limit of that kind would never be exceeded.
  for (VectorXd L::*v : {&L::lower, &L::upper, &L::velocity, &L::torque, &L::tracking}) {
    wrongs.push_back([=](L& o) { (o.*v).resize(2); });
    for (int i = 0; i < 3; ++i) wrongs.push_back([=](L& o) { (o.*v)[i] = kNone; });
  }
  for (VectorXd L::*v : {&L::velocity, &L::torque, &L::tracking}) wrongs.push_back([=](L& o) { (o.*v)[1] = 0.0; });
  refuses<L>(good, wrongs, [&](const L& o) { SafetySupervisor(arm, o); });
}

// Every state and every fault has words of its own.
template <typename Enum>
void expect_words(Enum last) {
  std::set<std::string> words;
  for (int k = 0; k <= static_cast<int>(last); ++k) words.insert(describe(static_cast<Enum>(k)));
  EXPECT_EQ(words.size(), static_cast<size_t>(last) + 1);
  EXPECT_EQ(words.count(""), 0U);
}

TEST(Descriptions, EveryStateHasADescriptionOfItsOwn) {
  expect_words(CooperativeState::kNotFinite);
  expect_words(SafetyState::kFault);
  expect_words(SafetyFault::kNotHeld);
}

}  // namespace
}  // namespace veridyn
