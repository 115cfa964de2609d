#include <gtest/gtest.h>

#include "support/energy.hpp"
#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"

// Energies from homogeneous poses and exact derivatives against the recursions: two derivations
// that share nothing but the model.

namespace veridyn {
namespace {

class LagrangeOnEverySampleArm : public OnSampleArm {};
INSTANTIATE_TEST_SUITE_P(Sample, LagrangeOnEverySampleArm, testing::ValuesIn(all_arm_names()),
                         sample_arm_name);

constexpr double kRounding = 1e-13;  // relative; both sides add some thousand products

using D1 = Dual<double>;
using D2 = Dual<D1>;

TEST_P(LagrangeOnEverySampleArm, InverseDynamicsAreLagrangesEquations) {
  for (const State& s : test_states(joints(), 31)) {
    const VectorXd tau = inverse_dynamics(arm(), s.q, s.dq, s.ddq);
    EXPECT_TRUE(near(tau, torques_of_lagrange(arm(), s), kRounding * (10.0 + 10 * tau.norm())));
  }
}

// M_ij = d2 E_kin / d(dq_i) d(dq_j), at dq = 0 so that nothing else is added.
TEST_P(LagrangeOnEverySampleArm, MassMatrixIsTheHessianOfKineticEnergy) {
  for (const State& s : test_states(joints(), 32)) {
    const int n = joints();
    MatrixXd hessian(n, n);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        std::vector<D2> q(n);
        std::vector<D2> dq(n);
        for (int k = 0; k < n; ++k) {
          q[k] = D2(s.q[k]);
          dq[k] = D2(D1(0.0, i == k ? 1.0 : 0.0), D1(j == k ? 1.0 : 0.0));
        }
        hessian(i, j) = energy(arm(), q, dq).kinetic.derivative.derivative;
      }
    }
    EXPECT_TRUE(near(mass_matrix(arm(), s.q), hessian, kRounding * (1.0 + 10 * hessian.norm())));
  }
}

TEST_P(LagrangeOnEverySampleArm, GravityTorquesAreTheSlopeOfPotentialEnergy) {
  RigidBodyDynamics dynamics(arm(), phi());
  VectorXd g(joints());
  for (const State& s : test_states(joints(), 33)) {
    dynamics.gravity_torques(s.q, g);
    VectorXd slope(joints());
    for (int i = 0; i < joints(); ++i) {
      std::vector<D1> q(joints());
      for (int k = 0; k < joints(); ++k) q[k] = D1(s.q[k], i == k ? 1.0 : 0.0);
      slope[i] = energy(arm(), q, std::vector<D1>(joints())).potential.derivative;
    }
    EXPECT_TRUE(near(g, slope, kRounding * (10.0 + 10 * g.norm())));
  }
}

// Power in = dE/dt, summed over a motion that is integrated with the library's own forward dynamics
// (Runge-Kutta of order four, the work of the drives as one more state).
TEST_P(LagrangeOnEverySampleArm, WorkOfTheDrivesIsTheGainInEnergy) {
  const int n = joints();
  RigidBodyDynamics dynamics(arm(), phi());
  Random random(34);
  const VectorXd amplitude = random.vector(n, -1, 1);
  struct Rate {
    VectorXd dq, ddq;
    double power;
  };
  const auto rate = [&](double t, const VectorXd& q, const VectorXd& dq) {
    const VectorXd tau = amplitude * std::cos(5 * t);
    VectorXd ddq(n);
    EXPECT_TRUE(dynamics.forward_dynamics(q, dq, tau, ddq));
    return Rate{dq, ddq, tau.dot(dq)};
  };
  const auto total = [&](const VectorXd& q, const VectorXd& dq) {
    const Energy<double> e = energy(arm(), std::vector<double>(q.begin(), q.end()),
                                    std::vector<double>(dq.begin(), dq.end()));
    return e.kinetic + e.potential;
  };
  VectorXd q = random.vector(n, -1, 1);
  VectorXd dq = random.vector(n, -0.5, 0.5);
  const double start = total(q, dq);
  double work = 0.0;
  double turned_over = 0.0;
  const double h = 2e-4;
  for (int step = 0; step < 500; ++step) {
    const double t = h * step;
    const Rate k1 = rate(t, q, dq);
    const Rate k2 = rate(t + h / 2, q + h / 2 * k1.dq, dq + h / 2 * k1.ddq);
    const Rate k3 = rate(t + h / 2, q + h / 2 * k2.dq, dq + h / 2 * k2.ddq);
    const Rate k4 = rate(t + h, q + h * k3.dq, dq + h * k3.ddq);
    q += h / 6 * (k1.dq + 2 * k2.dq + 2 * k3.dq + k4.dq);
    dq += h / 6 * (k1.ddq + 2 * k2.ddq + 2 * k3.ddq + k4.ddq);
    work += h / 6 * (k1.power + 2 * k2.power + 2 * k3.power + k4.power);
    turned_over +=
        h * std::abs(k1.power) + h * std::abs(arm().gravity().norm() * phi()[0] * k1.dq.norm());
  }
  EXPECT_GT(turned_over, 1e-3);
  // The global error of the method: h^4 / 120 times fifth derivatives, here rates of up to 50/s.
  EXPECT_NEAR(total(q, dq) - start, work, std::pow(50 * h, 4) / 120 * (1 + turned_over));
}

}  // namespace
}  // namespace veridyn
