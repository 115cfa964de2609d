#include "dynamics/state_model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "math/processor.hpp"
#include "support/malloc_count.hpp"
#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/regressor_batch.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"

// The kernels of single states against the recursions over links (recursion.hpp), which share no
// line with them, against their dual numbers, and against central differences.

namespace veridyn {
namespace {

constexpr double kRounding = 1e-12;  // relative; both sides add some thousand products

class OnEveryArm : public OnSampleArm {
 protected:
  MatrixXd row(const VectorXd& v) const { return v.transpose(); }
};
INSTANTIATE_TEST_SUITE_P(Sample, OnEveryArm, testing::ValuesIn(sample_arm_names()),
                         sample_arm_name);

std::vector<StateKernels> all_kernels() {
  std::vector<StateKernels> all = {state_kernels_baseline()};
  if (widest_instruction_set() >= InstructionSet::kAvx2) all.push_back(state_kernels_avx2());
  if (widest_instruction_set() >= InstructionSet::kAvx512) all.push_back(state_kernels_avx512());
  all.erase(std::remove_if(all.begin(), all.end(),
                           [](const StateKernels& k) { return k.workspace == nullptr; }),
            all.end());
  return all;
}

TEST_P(OnEveryArm, AllInstructionSetsDoWhatTheRecursionsDo) {
  const int n = joints();
  const StateModel model(Tree(arm()), phi());
  const RegressorBatch batch(arm());
  const auto columns = static_cast<Eigen::Index>(phi().size());
  for (const StateKernels& kernels : all_kernels()) {
    std::vector<double> memory(kernels.workspace(model.view()) + 8,
                               std::numeric_limits<double>::quiet_NaN());
    double* work = StateModel::aligned(memory);
    for (const State& s : test_states(n, 51)) {
      MatrixXd expected;
      batch.torques(row(s.q), row(s.dq), row(s.ddq), phi(), expected);
      MatrixXd slopes;
      batch.torque_slopes(row(s.q), row(s.dq), row(s.ddq), phi(), slopes);
      const Eigen::Map<const MatrixXd> by_all(slopes.data(), n, 3 * n);
      const double scale = 1.0 + expected.norm() + slopes.norm();
      VectorXd tau(n);
      kernels.inverse_dynamics(model.view(), s.q.data(), s.dq.data(), s.ddq.data(), tau.data(),
                               work);
      EXPECT_TRUE(near(tau, expected.transpose(), kRounding * scale));
      MatrixXd Y(n, columns);
      kernels.regressor(model.view(), s.q.data(), s.dq.data(), s.ddq.data(), Y.data(), work);
      EXPECT_TRUE(near(Y * phi(), expected.transpose(), kRounding * scale));
      MatrixXd by_q(n, n);
      MatrixXd by_dq(n, n);
      MatrixXd M(n, n);
      kernels.slopes(model.view(), s.q.data(), s.dq.data(), s.ddq.data(), tau.data(), by_q.data(),
                     by_dq.data(), M.data(), work);
      EXPECT_TRUE(near(tau, expected.transpose(), kRounding * scale));
      EXPECT_TRUE(near(by_q, by_all.leftCols(n), kRounding * scale));
      EXPECT_TRUE(near(by_dq, by_all.middleCols(n, n), kRounding * scale));
      EXPECT_TRUE(near(M, by_all.rightCols(n), kRounding * scale));
      VectorXd h(n);
      MatrixXd same(n, n);
      kernels.equation(model.view(), s.q.data(), s.dq.data(), same.data(), h.data(), work);
      EXPECT_TRUE(near(same * s.ddq + h, expected.transpose(), kRounding * scale));
    }
  }
}

// Entries of columns that no body or no motion gives are zeros and not leftovers of the workspace.
TEST_P(OnEveryArm, TheRegressorWritesEveryEntry) {
  TorqueRegressor regressor(arm());
  const RegressorBatch batch(arm());
  const State s = test_states(joints(), 52).back();
  MatrixXd Y = MatrixXd::Constant(joints(), phi().size(), 1e300);
  regressor.evaluate(s.q, s.dq, s.ddq, Y);
  std::vector<MatrixXd> of_batch;
  batch.evaluate(row(s.q), row(s.dq), row(s.ddq), of_batch);
  MatrixXd expected = MatrixXd::Zero(joints(), phi().size());
  for (int i = 0; i < joints(); ++i) {
    for (size_t c = 0; c < batch.columns(i).size(); ++c)
      expected(i, batch.columns(i)[c]) =
          of_batch[static_cast<size_t>(i)](0, static_cast<Eigen::Index>(c));
  }
  EXPECT_TRUE(near(Y, expected, kRounding * (1.0 + expected.norm())));
}

// d ddq / dx by central differences of forward dynamics; their error is h^2/6 f''' + eps/h f with
// all f of these arms below 1e3 of the acceleration.
TEST_P(OnEveryArm, ForwardDynamicsChangesAsItsDerivativesSay) {
  const int n = joints();
  RigidBodyDynamics dynamics(arm(), phi());
  const double step = std::cbrt(std::numeric_limits<double>::epsilon());
  for (const State& s : test_states(n, 53)) {
    VectorXd tau(n);
    dynamics.inverse_dynamics(s.q, s.dq, s.ddq, tau);
    VectorXd ddq(n);
    RigidBodyDynamics::AccelerationSlopes slopes;
    ASSERT_TRUE(dynamics.forward_dynamics_slopes(s.q, s.dq, tau, ddq, slopes));
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
  RigidBodyDynamics::TorqueSlopes torque;
  RigidBodyDynamics::AccelerationSlopes acceleration;
  long before = 0;
  for (int turn = 0; turn < 2; ++turn) {
    before = malloc_count();
    dynamics.equation_of_motion(s.q, s.dq, M, tau);
    dynamics.inverse_dynamics_slopes(s.q, s.dq, s.ddq, tau, torque);
    dynamics.forward_dynamics_slopes(s.q, s.dq, tau, ddq, acceleration);
    regressor.evaluate(s.q, s.dq, s.ddq, Y);
  }
  EXPECT_EQ(malloc_count(), before);
}

// Beyond the range of the quick sine a joint still is where it is.
TEST_P(OnEveryArm, WholeTurnsDoNotMatter) {
  // Its cables turn a motor's turn into a part of a turn, and into metres.
  if (GetParam() == "coupled_wrist") GTEST_SKIP() << "a turn of a motor is no turn of a link";
  RigidBodyDynamics dynamics(arm(), phi());
  State s = test_states(joints(), 55).back();
  VectorXd here(joints());
  dynamics.gravity_torques(s.q, here);
  for (int i = 0; i < joints(); ++i) {
    if (!arm().coordinates()[static_cast<size_t>(i)].prismatic) s.q[i] += 2.0 * M_PI * 1048576.0;
  }
  VectorXd there(joints());
  dynamics.gravity_torques(s.q, there);
  EXPECT_TRUE(near(there, here, 1e-7 * (1.0 + here.norm())));
}

}  // namespace
}  // namespace veridyn
