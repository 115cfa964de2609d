#include "dynamics/arm_kernels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "math/processor.hpp"
#include "support/malloc_count.hpp"
#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/dynamics/torque_regressor.hpp"

// The kernels of every instruction set against one another: single states in lanes of columns
// against batches in lanes of samples; and their derivatives against central differences. All
// scalars against plain doubles: scalars_test.cpp.

namespace veridyn {
namespace {

constexpr double kRounding = 1e-12;  // relative; both sides add some thousand products

class OnEveryArm : public OnSampleArm {
 protected:
  MatrixXd row(const VectorXd& v) const { return v.transpose(); }
};
INSTANTIATE_TEST_SUITE_P(Sample, OnEveryArm, testing::ValuesIn(all_arm_names()),
                         sample_arm_name);

std::vector<ArmKernels> all_kernels() {
  std::vector<ArmKernels> all = {arm_kernels_baseline()};
  if (widest_instruction_set() >= InstructionSet::kAvx2) all.push_back(arm_kernels_avx2());
  if (widest_instruction_set() >= InstructionSet::kAvx512) all.push_back(arm_kernels_avx512());
  all.erase(std::remove_if(all.begin(), all.end(),
                           [](const ArmKernels& k) { return k.lanes == 0; }),
            all.end());
  return all;
}

TEST_P(OnEveryArm, KernelsOfAllInstructionSetsGiveTheSameResults) {
  const int n = joints();
  const Tree tree(arm(), Tree::Keep::kMovingLinks);
  std::vector<LinkInertia> inertia(tree.links.size());
  link_inertias(tree, phi().data(), inertia.data());
  const InertialLinks links{tree, inertia.data()};
  const TorqueRegressor batch(arm());
  for (const ArmKernels& kernels : all_kernels()) {
    internal::AlignedWorkspace memory(kernels.workspace(tree));
    double* work = memory.get();
    std::fill_n(work, kernels.workspace(tree) / sizeof(double),
                std::numeric_limits<double>::quiet_NaN());
    for (const State& s : test_states(n, 51)) {
      const double* q = s.q.data();
      const double* dq = s.dq.data();
      const double* ddq = s.ddq.data();
      MatrixXd expected;
      batch.torques(row(s.q), row(s.dq), row(s.ddq), phi(), expected);
      MatrixXd derivatives;
      batch.torque_derivatives(row(s.q), row(s.dq), row(s.ddq), phi(), derivatives);
      const Eigen::Map<const MatrixXd> by_all(derivatives.data(), n, 3 * n);
      const double allowed = kRounding * (1.0 + expected.norm() + derivatives.norm());
      VectorXd tau(n);
      kernels.inverse_dynamics(links, q, dq, ddq, nullptr, 0, tau.data(), work);
      EXPECT_TRUE(near(tau, expected.transpose(), allowed));
      MatrixXd Y(n, phi().size());
      kernels.regressor(tree, q, dq, ddq, Y.data(), work);
      EXPECT_TRUE(near(Y * phi(), expected.transpose(), allowed));
      MatrixXd by_q(n, n), by_dq(n, n), M(n, n), same(n, n);
      kernels.derivatives(links, q, dq, ddq, tau.data(), by_q.data(), by_dq.data(), M.data(),
                          work);
      EXPECT_TRUE(near(tau, expected.transpose(), allowed));
      EXPECT_TRUE(near(by_q, by_all.leftCols(n), allowed));
      EXPECT_TRUE(near(by_dq, by_all.middleCols(n, n), allowed));
      EXPECT_TRUE(near(M, by_all.rightCols(n), allowed));
      VectorXd h(n);
      kernels.velocity_derivative(links, q, dq, 1.0, same.data(), h.data(), by_q.data(), work);
      EXPECT_TRUE(near(same, M, allowed));
      EXPECT_TRUE(near(same * s.ddq + h, expected.transpose(), allowed));
      kernels.velocity_derivative(links, q, dq, 0.5, nullptr, nullptr, same.data(), work);
      EXPECT_TRUE(near(2.0 * same, by_q, allowed));
      VectorXd g(n), gradient(n);
      kernels.gravity_torques(links, q, g.data(), work);
      kernels.lagrangian_gradient(links, q, dq, gradient.data(), work);
      EXPECT_TRUE(near(gradient, same.transpose() * s.dq - g, allowed));
      VectorXd back(n);
      ASSERT_TRUE(kernels.forward_dynamics(links, q, dq, tau.data(), back.data(), same.data(), work));
      EXPECT_TRUE(near(M * back, M * s.ddq, 100.0 * allowed));
      MatrixXd ddq_by_q(n, n), ddq_by_dq(n, n), inverse(n, n);
      ASSERT_TRUE(kernels.forward_derivatives(links, q, dq, tau.data(), back.data(),
                                              ddq_by_q.data(), ddq_by_dq.data(), inverse.data(),
                                              work));
      // dtau/dx is linear in ddq, and so is its error in that of ddq.
      const double loose = 1e3 * allowed * (1.0 + inverse.norm() * M.norm());
      EXPECT_TRUE(near(M * ddq_by_q, -by_all.leftCols(n), loose));
      EXPECT_TRUE(near(M * ddq_by_dq, -by_all.middleCols(n, n), loose));
      EXPECT_TRUE(near(M * inverse, MatrixXd::Identity(n, n), loose));
    }
  }
}

// A matrix with entries behind it that no kernel may change.
class Guarded {
 public:
  explicit Guarded(int entries) : size_(static_cast<size_t>(entries)), all_(size_ + kBehind, kUntouched) {}
  double* data() { return all_.data(); }
  bool is_written_exactly() const {
    const auto end = all_.begin() + static_cast<long>(size_);
    return std::count(all_.begin(), end, kUntouched) == 0 && std::count(end, all_.end(), kUntouched) == kBehind;
  }

 private:
  static constexpr int kBehind = 64;
  static constexpr double kUntouched = 1e300;
  size_t size_;
  std::vector<double> all_;
};

// Kernels store whole vectors of lanes, also where a matrix is smaller than one.
TEST_P(OnEveryArm, KernelsWriteNothingBeyondTheirOutputMatrices) {
  const int n = joints();
  const Tree tree(arm(), Tree::Keep::kMovingLinks);
  std::vector<LinkInertia> inertia(tree.links.size());
  link_inertias(tree, phi().data(), inertia.data());
  const InertialLinks links{tree, inertia.data()};
  const State s = test_states(n, 57).back();
  const double *q = s.q.data(), *dq = s.dq.data(), *ddq = s.ddq.data();
  for (const ArmKernels& kernels : all_kernels()) {
    internal::AlignedWorkspace memory(kernels.workspace(tree));
    double* work = memory.get();
    Guarded M(n * n), by_q(n * n), by_dq(n * n), D(n * n), same(n * n), Y(n * static_cast<int>(phi().size()));
    Guarded ddq_by_q(n * n), ddq_by_dq(n * n), inverse(n * n), tau(n), h(n), g(n), gradient(n), back(n);
    kernels.derivatives(links, q, dq, ddq, tau.data(), by_q.data(), by_dq.data(), M.data(), work);
    kernels.velocity_derivative(links, q, dq, 1.0, same.data(), h.data(), D.data(), work);
    kernels.gravity_torques(links, q, g.data(), work);
    kernels.lagrangian_gradient(links, q, dq, gradient.data(), work);
    kernels.forward_derivatives(links, q, dq, tau.data(), back.data(), ddq_by_q.data(), ddq_by_dq.data(), inverse.data(), work);
    kernels.regressor(tree, q, dq, ddq, Y.data(), work);
    for (const Guarded* one : {&M, &by_q, &by_dq, &D, &same, &Y, &ddq_by_q, &ddq_by_dq, &inverse, &tau, &h, &g, &gradient, &back})
      EXPECT_TRUE(one->is_written_exactly()) << kernels.lanes << " lanes";
    Guarded mass(n * n), of_motion(n * n), sum(n);
    kernels.mass_matrix(links, q, mass.data(), work);
    kernels.equation_of_motion(links, q, dq, of_motion.data(), sum.data(), work);
    for (const Guarded* one : {&mass, &of_motion, &sum}) EXPECT_TRUE(one->is_written_exactly()) << kernels.lanes << " lanes";
  }
}

// Forward dynamics has no answer where M is not positive definite.
TEST_P(OnEveryArm, AMassBelowZeroIsRefused) {
  RigidBodyDynamics dynamics(arm(), -phi());
  const State s = test_states(joints(), 56).back();
  VectorXd ddq(joints());
  EXPECT_FALSE(dynamics.forward_dynamics(s.q, s.dq, s.dq, ddq));
}

// Entries of columns that no body or no motion gives are zeros and not leftovers of the workspace.
TEST_P(OnEveryArm, TheRegressorWritesEveryEntry) {
  TorqueRegressor regressor(arm());
  const TorqueRegressor batch(arm());
  const State s = test_states(joints(), 52).back();
  MatrixXd Y = MatrixXd::Constant(joints(), phi().size(), 1e300);
  regressor.evaluate(s.q, s.dq, s.ddq, Y);
  std::vector<MatrixXd> of_batch;
  batch.evaluate(row(s.q), row(s.dq), row(s.ddq), of_batch);
  MatrixXd expected = MatrixXd::Zero(joints(), phi().size());
  for (int i = 0; i < joints(); ++i) {
    for (size_t c = 0; c < batch.columns({i}).size(); ++c)
      expected(i, batch.columns({i})[c]) =
          of_batch[i](0, static_cast<Eigen::Index>(c));
  }
  EXPECT_TRUE(near(Y, expected, kRounding * (1.0 + expected.norm())));
}

// d ddq / dx by central differences of forward dynamics; their error is h^2/6 f''' + eps/h f with
// all f of these arms below 1e3 of the acceleration.
TEST_P(OnEveryArm, ForwardDynamicsDerivativesMatchCentralDifferences) {
  const int n = joints();
  RigidBodyDynamics dynamics(arm(), phi());
  const double step = std::cbrt(std::numeric_limits<double>::epsilon());
  for (const State& s : test_states(n, 53)) {
    VectorXd tau(n);
    dynamics.inverse_dynamics(s.q, s.dq, s.ddq, tau);
    VectorXd ddq(n);
    RigidBodyDynamics::AccelerationDerivatives slopes;
    ASSERT_TRUE(dynamics.forward_dynamics_derivatives(s.q, s.dq, tau, ddq, slopes));
    MatrixXd M(n, n);
    dynamics.mass_matrix(s.q, M);
    EXPECT_TRUE(near(M * slopes.by_tau, MatrixXd::Identity(n, n), 1e-10 * M.norm()));
    const double condition = slopes.by_tau.norm() * M.norm();
    const double allowed =
        1e3 * condition * step * step * (1.0 + slopes.by_q.norm() + slopes.by_dq.norm());
    for (int j = 0; j < n; ++j) {
      const auto difference = [&](VectorXd State::* of) {
        State ahead = s;
        State behind = s;
        (ahead.*of)[j] += step;
        (behind.*of)[j] -= step;
        VectorXd up(n);
        VectorXd down(n);
        EXPECT_TRUE(dynamics.forward_dynamics(ahead.q, ahead.dq, tau, up));
        EXPECT_TRUE(dynamics.forward_dynamics(behind.q, behind.dq, tau, down));
        return VectorXd((up - down) / (2 * step));
      };
      EXPECT_TRUE(near(slopes.by_q.col(j), difference(&State::q), allowed));
      EXPECT_TRUE(near(slopes.by_dq.col(j), difference(&State::dq), allowed));
    }
  }
}

TEST_P(OnEveryArm, DerivativesAndRegressorAllocateNothingTheSecondTime) {
  if (VERIDYN_COUNTS_MALLOC == 0) GTEST_SKIP() << "the sanitizer has a malloc of its own";
  RigidBodyDynamics dynamics(arm(), phi());
  TorqueRegressor regressor(arm());
  const State s = test_states(joints(), 54).back();
  VectorXd tau(joints());
  VectorXd ddq(joints());
  MatrixXd M(joints(), joints());
  MatrixXd Y(joints(), phi().size());
  RigidBodyDynamics::TorqueDerivatives torque;
  RigidBodyDynamics::AccelerationDerivatives acceleration;
  long before = 0;
  for (int turn = 0; turn < 2; ++turn) {
    before = malloc_count();
    dynamics.equation_of_motion(s.q, s.dq, M, tau);
    dynamics.inverse_dynamics_derivatives(s.q, s.dq, s.ddq, tau, torque);
    dynamics.forward_dynamics_derivatives(s.q, s.dq, tau, ddq, acceleration);
    regressor.evaluate(s.q, s.dq, s.ddq, Y);
  }
  EXPECT_EQ(malloc_count(), before);
}

// Beyond the range of the quick sine a joint still is where it is.
TEST_P(OnEveryArm, TorquesArePeriodicInWholeTurns) {
  // A motor's turn may be a part of a turn of a link, or metres.
  if (GetParam() == "coupled_wrist" || GetParam() == "long_tree")
    GTEST_SKIP() << "a turn of a motor is no turn of a link";
  RigidBodyDynamics dynamics(arm(), phi());
  State s = test_states(joints(), 55).back();
  VectorXd here(joints());
  dynamics.gravity_torques(s.q, here);
  for (int i = 0; i < joints(); ++i) {
    if (!arm().coordinates()[i].prismatic) s.q[i] += 2.0 * M_PI * 1048576.0;
  }
  VectorXd there(joints());
  dynamics.gravity_torques(s.q, there);
  EXPECT_TRUE(near(there, here, 1e-7 * (1.0 + here.norm())));
}

}  // namespace
}  // namespace veridyn
