#include "veridyn/simulation/world.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "simulation/plant_support.hpp"
#include "support/near.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/math/eigen_pose.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kStep = 1e-3;
// A substep of u radians moves the phase by u^3 / 12 at most; u is 1/12 in the world or less.
constexpr double kPhaseDrift = 1.0 / 12.0 / 12.0 / 12.0;
const std::vector<double> kStiffnesses{200.0, 2450.0, 50000.0, kRigidStiffness};

Model weightless(const Model& arm) {
  ModelDescription d = arm.description();
  d.gravity.setZero();
  d.effects.clear();
  return Model(std::move(d));
}

WorldArm standing(const Model& arm, const Eigen::Isometry3d& base = Eigen::Isometry3d::Identity()) {
  return {arm, std::make_unique<Plant>(arm), base};
}

Attachment end_of(const Model& arm, int index) {
  return {index, {static_cast<int>(arm.frames().size()) - 1}, Eigen::Vector3d::Zero()};
}

Attachment tool(const Model& arm, int index) {
  return {index, *arm.find_frame("tool"), Eigen::Vector3d(0.001, 0.002, -0.003)};
}

Member spring(const Attachment& from, const Attachment& to, double stiffness, double rest) {
  Member m;
  m.name = "spring";
  m.from = from;
  m.to = to;
  m.stiffness = stiffness;
  m.rest_length = rest;
  return m;
}

// Two slides on one line, 0.5 m apart, and a spring of 0.4 m between them.
World two_slides(double stiffness, double damping, bool pulls_only) {
  const Model arm = weightless(slide());
  std::vector<WorldArm> arms;
  arms.push_back(standing(arm));
  arms.push_back(standing(arm, Eigen::Isometry3d(Eigen::Translation3d(0.5, 0, 0))));
  WorldObjects objects;
  objects.members = {spring(end_of(arm, 0), end_of(arm, 1), stiffness, 0.4)};
  objects.members[0].damping = damping;
  objects.members[0].pulls_only = pulls_only;
  return World(std::move(arms), std::move(objects));
}

const std::vector<VectorXd> kIdle{one(0.0), one(0.0)};

// The distance of two masses on a spring: l0 + 0.1 cos(w t), w^2 = K (1/m + 1/m).
TEST(World, TwoMassesOnASpringFollowTheClosedFormOscillation) {
  for (const double stiffness : kStiffnesses) {
    World world = two_slides(stiffness, 0.0, false);
    const double omega = std::sqrt(2.0 * stiffness / mass_of(slide()));
    for (int k = 0; k < 1000; ++k) {
      EXPECT_NEAR(world.member(0).length, 0.4 + 0.1 * std::cos(omega * kStep * k),
                  0.1 * kPhaseDrift * omega * kStep * k + 1e-9)
          << stiffness << " at " << k;
      ASSERT_EQ(world.step(kIdle, kStep), StepStatus::kOk);
    }
  }
}

// m x'' + 2 c x' + 2 K x = 0 for the distance: e^(-c t / m) within the envelope.
TEST(World, DampingForceIsProportionalToVelocity) {
  const double m = mass_of(slide());
  World world = two_slides(2450.0, 4.0, false);
  const double decay = 4.0 / m;
  const double omega = std::sqrt(2.0 * 2450.0 / m - decay * decay);
  for (int k = 0; k < 500; ++k) {
    const double t = kStep * k;
    const double wave = std::cos(omega * t) + decay / omega * std::sin(omega * t);
    EXPECT_NEAR(world.member(0).length, 0.4 + 0.1 * std::exp(-decay * t) * wave,
                0.1 * kPhaseDrift * omega * t + 1e-6)
        << t;
    ASSERT_EQ(world.step(kIdle, kStep), StepStatus::kOk);
  }
}

TEST(World, AStringNeverPushesAndIsFreeWhenSlack) {
  World world = two_slides(50000.0, 5.0, true);
  bool was_slack = false;
  for (int k = 0; k < 300; ++k) {
    ASSERT_EQ(world.step(kIdle, kStep), StepStatus::kOk);
    EXPECT_GE(world.member(0).tension, 0.0);
    if (world.member(0).length > 0.4) continue;
    if (world.member(0).length < 0.05) break;  // they fly through each other
    EXPECT_EQ(world.member(0).tension, 0.0);
    EXPECT_LT(world.member(0).rate, 0.0);
    was_slack = true;
  }
  EXPECT_TRUE(was_slack);
}

double kinetic(const World& world, const std::vector<Model>& arms) {
  double sum = 0.0;
  for (size_t k = 0; k < arms.size(); ++k) {
    const VectorXd dq = world.dq(static_cast<int>(k));
    sum += 0.5 * dq.dot(mass_matrix(arms[k], world.q(static_cast<int>(k))) * dq);
  }
  return sum;
}

const Eigen::Isometry3d kTurnedBase = eigen(Posed{rotation_z(2.5) * rotation_x(0.2), {0.3, 0.1, 0.02}});

World two_psms(const Model& arm, double stiffness, double damping, double stretch) {
  std::vector<WorldArm> arms;
  arms.push_back(standing(arm));
  arms.push_back(standing(arm, kTurnedBase));
  WorldObjects objects;
  objects.members = {spring(tool(arm, 0), tool(arm, 1), stiffness, 1.0)};
  objects.members[0].damping = damping;
  World world(std::move(arms), std::move(objects));
  VectorXd q(3);
  q << 0.1, -0.2, 0.1;
  world.set_state(0, q, VectorXd::Zero(3));
  world.set_state(1, -q.cwiseAbs().cwiseProduct(Eigen::Vector3d(1, 1, -1)), VectorXd::Zero(3));
  world.attach(0, world.member(0).length - stretch);
  return world;
}

TEST(World, EnergyOfFrictionlessArmsAndASpringIsConserved) {
  const Model arm = weightless(robot("psm-3dof"));
  const std::vector<VectorXd> idle(2, VectorXd::Zero(3));
  for (const double stiffness : kStiffnesses) {
    World world = two_psms(arm, stiffness, 0.0, 0.004);
    const double before = world.object_energy();
    double worst = 0.0;
    for (int k = 0; k < 2000; ++k) {
      ASSERT_EQ(world.step(idle, kStep), StepStatus::kOk);
      const double now = world.object_energy() + kinetic(world, {arm, arm});
      worst = std::max(worst, std::abs(now - before));
      EXPECT_NEAR(world.work_on_objects(), world.object_energy() - before, 2e-3 * before);
    }
    EXPECT_LT(worst, 2e-3 * before) << stiffness;
  }
}

TEST(World, DampingNeverGeneratesEnergy) {
  const Model arm = weightless(robot("psm-3dof"));
  const std::vector<VectorXd> idle(2, VectorXd::Zero(3));
  for (const double stiffness : kStiffnesses) {
    World world = two_psms(arm, stiffness, 0.02 * std::sqrt(stiffness), 0.004);
    const double start = world.object_energy();
    double last = start;
    for (int k = 0; k < 1000; ++k) {
      ASSERT_EQ(world.step(idle, kStep), StepStatus::kOk);
      const double now = world.object_energy() + kinetic(world, {arm, arm});
      EXPECT_LE(now, last + 1e-6 * start) << stiffness << " at " << k;
      last = now;
    }
    EXPECT_LT(last, 0.995 * start);
  }
}

// The torque that holds a stretched member is J' f, with f along the line between the points.
TEST(World, AnArmHoldsAMemberWithTheTransposedJacobian) {
  const Model arm = weightless(robot("psm-3dof"));
  World world = two_psms(arm, 2450.0, 0.0, 0.002);
  EXPECT_NEAR(world.member(0).tension, 4.9, 1e-9);
  const Eigen::Vector3d a = world.point(tool(arm, 0)).position;
  const Eigen::Vector3d b = world.point(tool(arm, 1)).position;
  EXPECT_NEAR((b - a).norm(), world.member(0).length, 1e-12);
  std::vector<VectorXd> tau;
  for (int k = 0; k < 2; ++k) {
    const VectorXd q = world.q(k);
    VectorXd hold = VectorXd::Zero(3);
    for (int i = 0; i < 3; ++i) {  // virtual work of the stretched spring
      VectorXd step = VectorXd::Zero(3);
      step[i] = 1e-6;
      world.set_state(k, q + step, VectorXd::Zero(3));
      const double more = world.object_energy();
      world.set_state(k, q - step, VectorXd::Zero(3));
      hold[i] = (more - world.object_energy()) / 2e-6;
    }
    world.set_state(k, q, VectorXd::Zero(3));
    tau.push_back(hold);
  }
  for (int k = 0; k < 200; ++k) ASSERT_EQ(world.step(tau, kStep), StepStatus::kOk);
  EXPECT_LT(world.dq(0).norm() + world.dq(1).norm(), 1e-5);
}

TEST(World, ASlideReboundsFromAnElasticWallWithItsSpeedReversed) {
  const Model arm = weightless(slide());
  std::vector<WorldArm> arms;
  arms.push_back(standing(arm));
  WorldObjects objects;
  Wall wall;
  wall.point = {0.1, 0, 0};
  wall.normal = {-1, 0, 0};
  wall.stiffness = 20000.0;
  wall.touches = end_of(arm, 0);
  objects.walls = {wall};
  World world(std::move(arms), std::move(objects));
  world.set_state(0, one(0.0), one(0.5));
  for (int k = 0; k < 400; ++k) ASSERT_EQ(world.step({one(0.0)}, kStep), StepStatus::kOk);
  EXPECT_NEAR(world.dq(0)[0], -0.5, 1e-3);
}

// A body on three grasps of the world settles where they carry its weight, and swings with its
// energy kept until then.
TEST(World, AHeldBodyRestsWhereGraspForcesEqualItsWeight) {
  // The arm's model brings gravity, in the axes of its base, which lies on its side.
  ModelDescription on_its_side = slide().description();
  on_its_side.gravity = {-9.81, 0, 0};
  const Model arm(on_its_side);
  std::vector<WorldArm> arms;
  arms.push_back(standing(arm, Eigen::Isometry3d(eigen(rotation_y(-M_PI / 2)))));
  HeldBody body;
  body.mass = 0.2;
  body.inertia = {1e-4, 2e-4, 1.5e-4};
  for (const double angle : {0.0, 2.1, 4.2}) {
    HeldBody::Grasp g;
    g.point_body = 0.05 * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.2);
    g.held_by.offset = g.point_body + Eigen::Vector3d(0, 0, 0.002);
    g.stiffness = 500.0;
    g.damping = 1.0;
    body.grasps.push_back(g);
  }
  WorldObjects objects;
  objects.bodies = {body};
  World world(std::move(arms), std::move(objects));
  for (int k = 0; k < 6000; ++k) ASSERT_EQ(world.step({one(0.0)}, kStep), StepStatus::kOk);
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (int g = 0; g < 3; ++g) force -= world.grasp_force(0, g);
  EXPECT_NEAR((force - Eigen::Vector3d(0, 0, 0.2 * 9.81)).norm(), 0.0, 1e-6);
  EXPECT_NEAR(world.body_velocity(0).norm() + world.body_spin(0).norm(), 0.0, 1e-6);
}

// Free, a body keeps its energy and its momentum however it tumbles.
TEST(World, AFreeBodyFollowsEulersEquations) {
  const Model arm = weightless(slide());
  std::vector<WorldArm> arms;
  arms.push_back(standing(arm));
  HeldBody body;
  body.mass = 0.2;
  body.inertia = {1e-4, 2e-4, 1.5e-4};
  HeldBody::Grasp g;  // a kick by a spring that lets go of nothing: it swings for ever
  g.point_body = {0.03, 0.02, 0.01};
  g.held_by.offset = {0.05, 0.01, 0.03};
  g.stiffness = 200.0;
  body.grasps = {g};
  WorldObjects objects;
  objects.bodies = {body};
  World world(std::move(arms), std::move(objects));
  const double before = world.object_energy();
  for (int k = 0; k < 2000; ++k) {
    ASSERT_EQ(world.step({one(0.0)}, kStep), StepStatus::kOk);
    ASSERT_NEAR(world.object_energy(), before, 1e-2 * before) << k;
  }
}

TEST(World, NamesTheInvalidValueOfAnObject) {
  const Model arm = weightless(slide());
  const auto build = [&](const Member& m) {
    std::vector<WorldArm> arms;
    arms.push_back(standing(arm));
    WorldObjects objects;
    objects.members = {m};
    World world(std::move(arms), std::move(objects));
  };
  EXPECT_NO_THROW(build(spring(end_of(arm, 0), {}, 100.0, 0.1)));
  EXPECT_THROW(build(spring(end_of(arm, 1), {}, 100.0, 0.1)), InvalidInput);
  EXPECT_THROW(build(spring({0, 7, {0, 0, 0}}, {}, 100.0, 0.1)), InvalidInput);
  EXPECT_THROW(build(spring(end_of(arm, 0), {}, -1.0, 0.1)), InvalidInput);
  EXPECT_THROW(build(spring(end_of(arm, 0), {}, 100.0, NAN)), InvalidInput);
}

}  // namespace
}  // namespace veridyn
