#include <benchmark/benchmark.h>

#include <vector>

#include "support/sample_arms.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/kinematics/point_motion.hpp"

// Rigid-body dynamics of an arm (modified DH, ten parameters on every link) of 7, 30 and 60 joints,
// nanoseconds per state over a pool of moving states: one state again and again would stay in the
// branch predictor.

namespace veridyn {
namespace {

constexpr int kJoints = 7;
constexpr int kPool = 512;

Model chain(int joints) {
  ArmBuilder builder("chain", joints, 61);
  const double alpha[] = {0, -M_PI / 2, M_PI / 2, M_PI / 2, -M_PI / 2, -M_PI / 2, M_PI / 2};
  const double d[] = {0.34, 0, 0.4, 0, 0.39, 0, 0.08};
  for (int i = 0; i < joints; ++i) {
    builder.dh_link(JointType::kRevolute, i,
                    {DhConvention::kModified, 0.01 * (i % 7), alpha[i % 7], d[i % 7], 0.0});
  }
  return builder.build();
}

struct Pool {
  int joints;
  Model arm = chain(joints);
  RigidBodyDynamics dynamics{arm, *arm.inertial_values()};
  PointMotion tip{Tree(arm, Tree::Keep::kMovingLinks), {joints - 1}};
  VectorXd out = VectorXd::Zero(joints);
  MatrixXd matrix = MatrixXd::Zero(joints, joints);
  RigidBodyDynamics::TorqueDerivatives torque;
  RigidBodyDynamics::AccelerationDerivatives acceleration;
  std::vector<State> states;
  size_t at = 0;

  explicit Pool(int n) : joints(n) {
    Random random(62);
    for (int k = 0; k < kPool; ++k)
      states.push_back({random.vector(n, -3, 3), random.vector(n, -2, 2), random.vector(n, -5, 5)});
  }

  const State& next() { return states[at++ % kPool]; }
};

template <typename Body>
void one_state(benchmark::State& state, const Body& body) {
  Pool pool(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    body(pool, pool.next());
    benchmark::ClobberMemory();
  }
}

#define VERIDYN_ONE_STATE(name, expression)                                        \
  void name(benchmark::State& state) {                                             \
    one_state(state, [](Pool& p, const State& s) { expression; });                 \
  }                                                                                \
  BENCHMARK(name)->Arg(7)->Arg(30)->Arg(60)

VERIDYN_ONE_STATE(inverse_dynamics, p.dynamics.inverse_dynamics(s.q, s.dq, s.ddq, p.out));
VERIDYN_ONE_STATE(gravity, p.dynamics.gravity_torques(s.q, p.out));
VERIDYN_ONE_STATE(mass, p.dynamics.mass_matrix(s.q, p.matrix));
VERIDYN_ONE_STATE(coriolis, p.dynamics.coriolis_matrix(s.q, s.dq, p.matrix));
VERIDYN_ONE_STATE(forward_dynamics, p.dynamics.forward_dynamics(s.q, s.dq, s.ddq, p.out));
VERIDYN_ONE_STATE(inverse_derivatives,
                  p.dynamics.inverse_dynamics_derivatives(s.q, s.dq, s.ddq, p.out, p.torque));
VERIDYN_ONE_STATE(forward_derivatives,
                  p.dynamics.forward_dynamics_derivatives(s.q, s.dq, s.ddq, p.out, p.acceleration));
VERIDYN_ONE_STATE(pose_of_the_tip, p.tip.place(s.q.data()));
VERIDYN_ONE_STATE(jacobian, p.tip.update(s.q.data()));
VERIDYN_ONE_STATE(jacobian_and_rate, p.tip.update(s.q.data(), s.dq.data()));

// The batch forms, over blocks of rows; "per_state" is the time of one of them.
struct Block {
  Model arm = chain(kJoints);
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
