#include "veridyn/dynamics/recursion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/kinematics/tree.hpp"
#include "math/dual.hpp"
#include "math/pack.hpp"

namespace veridyn {
namespace {

class RecursionOnEverySampleArm : public OnSampleArm {};
INSTANTIATE_TEST_SUITE_P(Sample, RecursionOnEverySampleArm, testing::ValuesIn(sample_arm_names()),
                         sample_arm_name);

constexpr double kRounding = 1e-13;
const double kStep = std::cbrt(std::numeric_limits<double>::epsilon());

template <typename S>
void forward_pass(const Tree& tree, const S* q, const S* dq, const S* ddq, const Vec3d& gravity,
                  const Workspace<S>& r) {
  joint_pass(tree, q, dq, ddq, r);
  for (size_t k = 0; k < tree.links.size(); ++k) forward_step(tree, static_cast<int>(k), gravity, r);
}

template <typename S>
std::vector<S> torques(const Tree& tree, const VectorXd& phi, const std::vector<S>& q,
                       const std::vector<S>& dq, const std::vector<S>& ddq) {
  Recursion<S> r(tree);
  std::vector<S> tau(q.size());
  std::vector<LinkInertia> inertia(tree.links.size());
  link_inertias(tree, phi.data(), inertia.data());
  forward_pass<S>(tree, q.data(), dq.data(), ddq.data(), tree.gravity, r);
  for (size_t k = 0; k < tree.links.size(); ++k)
    link_wrench(tree.links[k], inertia[k], r.link[k].accel, r.link[k].E, r.link[k].force,
                r.link[k].moment);
  backward_pass<S>(tree, r, tau.data());
  return tau;
}

// The derivative of inverse dynamics along a direction of (q, dq, ddq).
TEST_P(RecursionOnEverySampleArm, DualNumbersGiveTheDirectionalDerivativeOfTheTorques) {
  const Tree tree(arm(), Tree::Keep::kMovingLinks);
  Random random(81);
  for (const State& s : test_states(joints(), 82)) {
    const State along{random.vector(joints(), -1, 1), random.vector(joints(), -1, 1),
                      random.vector(joints(), -1, 1)};
    std::vector<Dual<double>> q;
    std::vector<Dual<double>> dq;
    std::vector<Dual<double>> ddq;
    for (int i = 0; i < joints(); ++i) {
      q.emplace_back(s.q[i], along.q[i]);
      dq.emplace_back(s.dq[i], along.dq[i]);
      ddq.emplace_back(s.ddq[i], along.ddq[i]);
    }
    const std::vector<Dual<double>> tau = torques(tree, phi(), q, dq, ddq);
    const auto at = [&](double step) {
      return inverse_dynamics(arm(), s.q + step * along.q, s.dq + step * along.dq,
                              s.ddq + step * along.ddq);
    };
    const VectorXd value = at(0.0);
    const VectorXd slope = (at(kStep) - at(-kStep)) / (2 * kStep);
    for (int i = 0; i < joints(); ++i) {
      EXPECT_NEAR(tau[i].value, value[i], kRounding * (10 + value.norm()));
      // Central differences: h^2/6 f''', and f''' is below 1000 |tau| where a motor turns seven
      // times as fast.
      EXPECT_NEAR(tau[i].derivative, slope[i], 1000 * kStep * kStep * (10 + value.norm()));
    }
  }
}

TEST_P(RecursionOnEverySampleArm, PacksGiveTheTorquesOfEachLane) {
  struct Here;
  using P = Pack<4, Here>;
  const Tree tree(arm(), Tree::Keep::kMovingLinks);
  const std::vector<State> states = test_states(joints(), 83);
  std::vector<P> q(joints());
  std::vector<P> dq(joints());
  std::vector<P> ddq(joints());
  for (int i = 0; i < joints(); ++i) {
    for (int l = 0; l < P::kSize; ++l) {
      q[i].v[l] = states[2 * l].q[i];
      dq[i].v[l] = states[2 * l].dq[i];
      ddq[i].v[l] = states[2 * l].ddq[i];
    }
  }
  const std::vector<P> tau = torques(tree, phi(), q, dq, ddq);
  for (int l = 0; l < P::kSize; ++l) {
    const State& s = states[2 * l];
    const VectorXd one = inverse_dynamics(arm(), s.q, s.dq, s.ddq);
    for (int i = 0; i < joints(); ++i)
      EXPECT_NEAR(tau[i].v[l], one[i], kRounding * (10 + one.norm()));
  }
}

// The velocity of each body is its Jacobian times dq; from rest its acceleration is J ddq, in the
// link's frame.
TEST_P(RecursionOnEverySampleArm, LinkVelocitiesAndAccelerationsFollowFromTheJacobians) {
  const Tree tree(arm());
  Recursion<double> r(tree), at_rest(tree);
  const VectorXd none = VectorXd::Zero(joints());
  for (const State& s : test_states(joints(), 84)) {
    forward_pass<double>(tree, s.q.data(), none.data(), s.ddq.data(), {0, 0, 0}, at_rest);
    forward_pass<double>(tree, s.q.data(), s.dq.data(), s.ddq.data(), {0, 0, 0}, r);
    jacobian_pass<double>(tree, r);
    for (size_t k = 0; k < tree.links.size(); ++k) {
      Vec3d omega{0, 0, 0};
      Vec3d alpha{0, 0, 0};
      Vec3d accel{0, 0, 0};
      for (int m = tree.links[k].first_support; m < tree.links[k].end_support; ++m) {
        const int i = tree.supports[m].coordinate;
        omega = omega + s.dq[i] * r.jacobian[m].w;
        alpha = alpha + s.ddq[i] * r.jacobian[m].w;
        accel = accel + s.ddq[i] * r.jacobian[m].v;
      }
      const auto eigen = [](const Vec3d& a) { return Eigen::Vector3d(a.x, a.y, a.z); };
      const double scale = 10 + eigen(accel).norm() + eigen(alpha).norm();
      EXPECT_TRUE(near(eigen(r.link[k].omega), eigen(omega), kRounding * scale));
      EXPECT_TRUE(near(eigen(at_rest.link[k].alpha), eigen(alpha), kRounding * scale));
      EXPECT_TRUE(near(eigen(at_rest.link[k].accel), eigen(accel), kRounding * scale));
    }
  }
}

}  // namespace
}  // namespace veridyn
