#include "veridyn/control/object_impedance.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

ObjectImpedanceOptions object(int hands) {
  ObjectImpedanceOptions o;
  o.mass = 0.7;
  o.inertia = {2e-3, 3e-3, 4e-3};
  o.wanted_mass = 1.5;
  o.damping = 20.0;
  o.stiffness = 300.0;
  o.wanted_inertia = 0.02;
  o.angular_damping = 0.4;
  o.angular_stiffness = 6.0;
  const std::vector<Vector3d> all{{0.05, 0.01, 0.0}, {-0.03, 0.05, 0.01}, {-0.02, -0.05, 0.02}};
  o.grasps.assign(all.begin(), all.begin() + hands);
  return o;
}

ObjectMotion somewhere() {
  ObjectMotion m;
  m.position = {0.6, 0.1, 0.05};
  m.rotation = Eigen::AngleAxisd(0.6, Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  m.velocity = {0.02, -0.01, 0.03};
  m.spin = {0.3, 0.5, -0.2};
  return m;
}

// Newton and Euler of the object under the hands' forces give the impedance that was asked for.
TEST(ObjectImpedance, TheObjectFollowsItsImpedanceEquation) {
  const ObjectImpedanceOptions o = object(3);
  ObjectImpedance control(o);
  const ObjectMotion now = somewhere();
  ObjectMotion wanted = now;
  wanted.position += Vector3d(0.01, -0.02, 0.005);
  const Vector3d turn(0.02, -0.01, 0.03);
  wanted.rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * now.rotation;
  wanted.velocity = {0.0, 0.05, 0.0};
  wanted.acceleration = {0.3, 0.1, -0.2};
  const Vector3d push(1.0, 0.5, -0.3);
  const auto& hands = control.update(now, wanted, push, Vector3d::Zero());
  Vector3d F = push + o.mass * o.gravity;
  Vector3d N = Vector3d::Zero();
  for (size_t i = 0; i < 3; ++i) {
    F += hands[i].force;
    N += (now.rotation * o.grasps[i]).cross(hands[i].force);
  }
  const Vector3d a = F / o.mass;
  const Vector3d left = o.wanted_mass * (a - wanted.acceleration) -
                        o.damping * (wanted.velocity - now.velocity) -
                        o.stiffness * (wanted.position - now.position);
  EXPECT_NEAR((left - push).norm(), 0.0, 1e-3);
  const Matrix3d I = now.rotation * o.inertia.asDiagonal() * now.rotation.transpose();
  const Vector3d alpha = I.inverse() * (N - now.spin.cross(Vector3d(I * now.spin)));
  const Vector3d angular = o.wanted_inertia * alpha - o.angular_damping * (wanted.spin - now.spin) -
                           o.angular_stiffness * turn;
  EXPECT_NEAR(angular.norm(), 0.0, 1e-3);
}

// Targets of the hands are points of the object where it is wanted: velocities and accelerations are the derivatives of positions.
TEST(ObjectImpedance, TargetsFormOneRigidMotion) {
  const ObjectImpedanceOptions o = object(3);
  ObjectImpedance control(o);
  const Vector3d spin(2.0, -1.0, 3.0), velocity(0.2, 0.1, -0.3);
  const auto wanted_at = [&](double t) {
    ObjectMotion m = somewhere();
    m.position += velocity * t;
    m.rotation = Eigen::AngleAxisd(spin.norm() * t, spin.normalized()) * m.rotation;
    m.velocity = velocity;
    m.spin = spin;
    return m;
  };
  const double h = 1e-4;
  const std::vector<TipTarget> before = control.update(somewhere(), wanted_at(-h), Vector3d::Zero(), Vector3d::Zero());
  const std::vector<TipTarget> at = control.update(somewhere(), wanted_at(0.0), Vector3d::Zero(), Vector3d::Zero());
  const std::vector<TipTarget> after = control.update(somewhere(), wanted_at(h), Vector3d::Zero(), Vector3d::Zero());
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_LT(((after[i].position - before[i].position) / (2.0 * h) - at[i].velocity).norm(), 1e-6);
    EXPECT_LT(((after[i].velocity - before[i].velocity) / (2.0 * h) - at[i].acceleration).norm(), 1e-6);
  }
}

TEST(ObjectImpedance, InternalForcesHaveNoResultantForceOrMoment) {
  ObjectImpedance plain(object(3));
  ObjectImpedance squeezed(object(3));
  ASSERT_TRUE(squeezed.set_internal_force(0, 1, 4.0));
  ASSERT_TRUE(squeezed.set_internal_force(1, 2, -2.0));
  const ObjectMotion now = somewhere();
  const std::vector<TipTarget> a = plain.update(now, now, Vector3d::Zero(), Vector3d::Zero());
  const std::vector<TipTarget> b = squeezed.update(now, now, Vector3d::Zero(), Vector3d::Zero());
  Vector3d F = Vector3d::Zero();
  Vector3d N = Vector3d::Zero();
  for (size_t i = 0; i < 3; ++i) {
    F += b[i].force - a[i].force;
    N += (now.rotation * object(3).grasps[i]).cross(b[i].force - a[i].force);
  }
  EXPECT_NEAR(F.norm() + N.norm(), 0.0, 1e-12);
  const Vector3d u = now.rotation * (object(3).grasps[0] - object(3).grasps[1]).normalized();
  EXPECT_NEAR((b[0].force - a[0].force - 4.0 * u).norm(), 0.0, 1e-12);  // pulls away
  EXPECT_FALSE(squeezed.set_internal_force(0, 0, 1.0));
  EXPECT_FALSE(squeezed.set_internal_force(0, 3, 1.0));
}

// Two hands carry the weight, and ask for nothing impossible about the line between them.
TEST(ObjectImpedance, ForcesOfTwoHandsAddUpToTheWeight) {
  ObjectImpedance control(object(2));
  ObjectMotion now;
  ObjectMotion wanted = now;
  wanted.rotation = Eigen::AngleAxisd(0.5, Vector3d::UnitX()).toRotationMatrix();
  const auto& hands = control.update(now, wanted, Vector3d::Zero(), Vector3d::Zero());
  const Vector3d F = hands[0].force + hands[1].force;
  EXPECT_NEAR((F - Vector3d(0, 0, 0.7 * 9.81)).norm(), 0.0, 1e-9);
  EXPECT_LT(hands[0].force.norm() + hands[1].force.norm(), 200.0);
}

TEST(ObjectImpedance, TheObjectsMotionIsEstimatedFromThatOfItsGrasps) {
  const ObjectImpedanceOptions o = object(3);
  ObjectImpedance control(o);
  const ObjectMotion truth = somewhere();
  std::vector<Vector3d> p, v;
  for (const Vector3d& grasp : o.grasps) {
    const Vector3d r = truth.rotation * grasp;
    p.push_back(truth.position + r);
    v.push_back(truth.velocity + truth.spin.cross(r));
  }
  ObjectMotion found;
  for (int k = 0; k < 20; ++k) found = control.estimate(p, v);
  EXPECT_NEAR((found.position - truth.position).norm(), 0.0, 1e-6);
  EXPECT_NEAR((found.rotation - truth.rotation).norm(), 0.0, 1e-6);
  EXPECT_NEAR((found.velocity - truth.velocity).norm(), 0.0, 1e-5);
  EXPECT_NEAR((found.spin - truth.spin).norm(), 0.0, 1e-4);
}

TEST(ObjectImpedance, RejectsInvalidOptions) {
  ObjectImpedanceOptions o = object(3);
  o.grasps.clear();
  EXPECT_THROW(ObjectImpedance{o}, InvalidInput);
  o = object(3);
  o.wanted_mass = 0.0;
  EXPECT_THROW(ObjectImpedance{o}, InvalidInput);
  o = object(3);
  o.stiffness = -1.0;
  EXPECT_THROW(ObjectImpedance{o}, InvalidInput);
}

}  // namespace
}  // namespace veridyn
