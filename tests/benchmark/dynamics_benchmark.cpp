#include <benchmark/benchmark.h>

#include <vector>

#include "support/sample_arms.hpp"
#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"

// Rigid-body dynamics of a seven-joint arm (modified DH, ten parameters on every link), nanoseconds
// per state over a pool of moving states: one state again and again would stay in the branch
// predictor.

namespace veridyn {
namespace {

constexpr int kJoints = 7;
constexpr int kPool = 512;

Model seven_joints() {
  ArmBuilder builder("seven_joints", kJoints, 61);
  const double alpha[] = {0, -M_PI / 2, M_PI / 2, M_PI / 2, -M_PI / 2, -M_PI / 2, M_PI / 2};
  const double d[] = {0.34, 0, 0.4, 0, 0.39, 0, 0.08};
  for (int i = 0; i < kJoints; ++i) {
    builder.dh_link(JointType::kRevolute, i,
                    {DhConvention::kModified, 0.01 * i, alpha[i], d[i], 0.0});
  }
  return builder.build();
}

struct Pool {
  Model arm = seven_joints();
  VectorXd phi = *arm.inertial_values();
  std::vector<State> states;
  size_t at = 0;

  Pool() {
    Random random(62);
    for (int k = 0; k < kPool; ++k) {
      states.push_back({random.vector(kJoints, -3, 3), random.vector(kJoints, -2, 2),
                        random.vector(kJoints, -5, 5)});
    }
  }

  const State& next() { return states[at++ % kPool]; }
};

void inverse_dynamics_one_state(benchmark::State& state) {
  Pool pool;
  RigidBodyDynamics dynamics(pool.arm, pool.phi);
  VectorXd tau(kJoints);
  for (auto _ : state) {
    const State& s = pool.next();
    dynamics.inverse_dynamics(s.q, s.dq, s.ddq, tau);
    benchmark::DoNotOptimize(tau.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(inverse_dynamics_one_state);

void mass_matrix_one_state(benchmark::State& state) {
  Pool pool;
  RigidBodyDynamics dynamics(pool.arm, pool.phi);
  MatrixXd M(kJoints, kJoints);
  for (auto _ : state) {
    dynamics.mass_matrix(pool.next().q, M);
    benchmark::DoNotOptimize(M.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(mass_matrix_one_state);

void coriolis_matrix_one_state(benchmark::State& state) {
  Pool pool;
  RigidBodyDynamics dynamics(pool.arm, pool.phi);
  MatrixXd C(kJoints, kJoints);
  for (auto _ : state) {
    const State& s = pool.next();
    dynamics.coriolis_matrix(s.q, s.dq, C);
    benchmark::DoNotOptimize(C.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(coriolis_matrix_one_state);

void forward_dynamics_one_state(benchmark::State& state) {
  Pool pool;
  RigidBodyDynamics dynamics(pool.arm, pool.phi);
  VectorXd ddq(kJoints);
  for (auto _ : state) {
    const State& s = pool.next();
    benchmark::DoNotOptimize(dynamics.forward_dynamics(s.q, s.dq, s.ddq, ddq));
    benchmark::ClobberMemory();
  }
}
BENCHMARK(forward_dynamics_one_state);

void torque_regressor_with_its_tree(benchmark::State& state) {
  Pool pool;
  for (auto _ : state) {
    const State& s = pool.next();
    benchmark::DoNotOptimize(torque_regressor(pool.arm, s.q, s.dq, s.ddq));
  }
}
BENCHMARK(torque_regressor_with_its_tree);

// The batch forms, over blocks of rows; "per_state" is the time of one of them.
struct Block {
  Model arm = seven_joints();
  VectorXd phi = *arm.inertial_values();
  TorqueRegressor batch{arm};
  MatrixXd q, dq, ddq;

  explicit Block(int rows) : q(rows, kJoints), dq(rows, kJoints), ddq(rows, kJoints) {
    Random random(63);
    for (int i = 0; i < kJoints; ++i) {
      q.col(i) = random.vector(rows, -3, 3);
      dq.col(i) = random.vector(rows, -2, 2);
      ddq.col(i) = random.vector(rows, -5, 5);
    }
  }
};

void report_per_state(benchmark::State& state) {
  using benchmark::Counter;
  state.counters["per_state"] = Counter(static_cast<double>(state.range(0)),
                                        Counter::kIsIterationInvariantRate | Counter::kInvert);
}

void inverse_dynamics_batch(benchmark::State& state) {
  const Block block(static_cast<int>(state.range(0)));
  MatrixXd tau;
  for (auto _ : state) {
    block.batch.torques(block.q, block.dq, block.ddq, block.phi, tau);
    benchmark::DoNotOptimize(tau.data());
    benchmark::ClobberMemory();
  }
  report_per_state(state);
}
BENCHMARK(inverse_dynamics_batch)->Arg(64)->Arg(256)->Arg(4096);

void regressor_batch(benchmark::State& state) {
  const Block block(static_cast<int>(state.range(0)));
  std::vector<MatrixXd> Y;
  for (auto _ : state) {
    block.batch.evaluate(block.q, block.dq, block.ddq, Y);
    benchmark::DoNotOptimize(Y.data());
    benchmark::ClobberMemory();
  }
  report_per_state(state);
}
BENCHMARK(regressor_batch)->Arg(64)->Arg(256)->Arg(4096);

}  // namespace
}  // namespace veridyn
