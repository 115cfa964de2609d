#include <benchmark/benchmark.h>

#include <time.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "support/malloc_count.hpp"
#include "support/random.hpp"
#include "veridyn/control/adaptive_friction.hpp"
#include "veridyn/control/computed_torque.hpp"
#include "veridyn/control/cooperative_controller.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/gravity_compensation.hpp"
#include "veridyn/control/impedance.hpp"
#include "veridyn/control/inverse_kinematics.hpp"
#include "veridyn/control/joint_controller.hpp"
#include "veridyn/control/model_error_observer.hpp"
#include "veridyn/control/quintic_interpolator.hpp"
#include "veridyn/control/teleoperation.hpp"
#include "veridyn/control/tip_controller.hpp"
#include "veridyn/control/velocity_observer.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

// One cycle of control of the seven-joint psm-wrist, from measured positions to torques. What
// counts in a loop is the worst, so every cycle is timed by itself. VERIDYN_CYCLES=10000000 runs that
// many of each in place of a second's. Each cycle is followed by an empty loop of the same length, which
// shows how often the machine is late. Which cycle is late of its own accord, repetitions tell
// (--benchmark_repetitions=3): each begins with a new controller and gives it the same inputs, so that a cycle has
// the same work to do in all of them, and what it takes at least is its own.

namespace veridyn {
namespace {

constexpr int kPool = 512;

struct Cycle {
  VectorXd q, dq;
};

struct Wrist {
  Model arm = plausible_model(read_model("psm-wrist"), 1).arm;
  Tip tip{"yaw1"};
  ArmState state{arm, tip};
  std::vector<Cycle> cycles;
  TaskReference wanted;
  Vector6d wrench{Vector6d::Zero()};
  VectorXd tau{VectorXd::Zero(arm.joints())};

  Wrist() {
    Random random(91);
    for (int k = 0; k < kPool; ++k) {
      VectorXd q = random.vector(arm.joints(), -0.6, 0.6);
      q[2] = random.in(0.08, 0.22);
      cycles.push_back({q, random.vector(arm.joints(), -0.5, 0.5)});
    }
  }
};

double microseconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

// The times of single cycles, sorted; as many as there is room for.
class Times {
 public:
  static constexpr double kLongest = 20.0;  // us
  Times() { us_.reserve(1U << 21); }
  void add(double us) {
    worst_us_ = std::max(worst_us_, us);
    beyond_ += us > kLongest;
    if (us_.size() < us_.capacity()) us_.push_back(us);
  }
  void report(benchmark::State& state, const std::string& clock) {
    std::sort(us_.begin(), us_.end());
    state.counters[clock + "_median_us"] = at(0.5);
    state.counters[clock + "_99.99_us"] = at(0.9999);
    state.counters[clock + "_worst_us"] = worst_us_;
    state.counters[clock + "_beyond_20_us"] = static_cast<double>(beyond_);
  }

 private:
  double at(double share) const {
    const auto rank = static_cast<size_t>(share * static_cast<double>(us_.size()));
    return us_[std::min(us_.size() - 1, rank)];
  }
  std::vector<double> us_;
  double worst_us_ = 0.0;
  long beyond_ = 0;
};

// The least time of each cycle of a benchmark over its repetitions.
class LeastTimes {
 public:
  void add(double us) {
    if (at_ == us_.size()) us_.push_back(static_cast<float>(us));
    us_[at_] = std::min(us_[at_], static_cast<float>(us));
    ++at_;
  }
  // The next repetition begins.
  void report(benchmark::State& state) {
    at_ = 0;
    state.counters["own_worst_us"] = *std::max_element(us_.begin(), us_.end());
    state.counters["own_beyond_20_us"] = static_cast<double>(
        std::count_if(us_.begin(), us_.end(), [](float us) { return us > Times::kLongest; }));
  }

 private:
  std::vector<float> us_;
  size_t at_ = 0;
};

void empty_loop(long turns) {
  for (long k = 0; k < turns; ++k) benchmark::DoNotOptimize(k);
}

// [us] of the processor for one call: the median of 501.
template <typename Call>
double usual_time(const Call& call) {
  std::vector<double> us(501);
  for (double& one : us) {
    const double start = microseconds(CLOCK_THREAD_CPUTIME_ID);
    call();
    one = microseconds(CLOCK_THREAD_CPUTIME_ID) - start;
  }
  std::nth_element(us.begin(), us.begin() + 250, us.end());
  return us[250];
}

// Runs `cycle` over the pool; `name` is the benchmark's. "wall" holds whatever else the machine does in between, "cpu" the
// cycle alone (and 0.3 us of asking for that clock), "empty" both of the empty loop; "allocations"
// are those of all cycles; "own" counts each cycle by the least wall time of all repetitions.
template <typename Update>
void time_cycles(benchmark::State& state, const std::string& name, Wrist& wrist, const Update& cycle) {
  static std::map<std::string, LeastTimes> of_all;
  LeastTimes& least = of_all[name];
  Times wall, cpu, empty_wall, empty_cpu;
  size_t at = 0;
  long allocations = 0;
  const auto timed = [](Times& of_wall, Times& of_cpu, const auto& call) {
    const double wall_start = microseconds(CLOCK_MONOTONIC);
    const double cpu_start = microseconds(CLOCK_THREAD_CPUTIME_ID);
    call();
    of_cpu.add(microseconds(CLOCK_THREAD_CPUTIME_ID) - cpu_start);
    const double us = microseconds(CLOCK_MONOTONIC) - wall_start;
    of_wall.add(us);
    return us;
  };
  constexpr long kTurns = 100000;
  const double clock = usual_time([] {});
  const double turn = (usual_time([] { empty_loop(kTurns); }) - clock) / kTurns;
  const double usual = usual_time([&] { cycle(wrist.cycles[at++ % kPool]); }) - clock;
  const auto turns = static_cast<long>(usual / turn);
  for (auto _ : state) {
    const Cycle& now = wrist.cycles[at++ % kPool];
    const long before = malloc_count();
    const double us = timed(wall, cpu, [&] { cycle(now); });
    allocations += malloc_count() - before;
    least.add(us);
    timed(empty_wall, empty_cpu, [&] { empty_loop(turns); });
    benchmark::DoNotOptimize(wrist.tau.data());
    benchmark::ClobberMemory();
  }
  least.report(state);
  wall.report(state, "wall");
  cpu.report(state, "cpu");
  empty_wall.report(state, "empty_wall");
  empty_cpu.report(state, "empty_cpu");
  state.counters["allocations"] = static_cast<double>(allocations);
}

void long_enough(benchmark::internal::Benchmark* one) {
  const char* cycles = std::getenv("VERIDYN_CYCLES");
  if (cycles != nullptr) one->Iterations(std::atol(cycles));
  else one->MinTime(1.0);
}

void arm_state(benchmark::State& state) {
  Wrist wrist;
  time_cycles(state, "arm_state", wrist, [&](const Cycle& c) { wrist.state.update(c.q, c.dq); });
}
BENCHMARK(arm_state)->Apply(long_enough);

void impedance_cycle(benchmark::State& state, TaskRows rows) {
  Wrist wrist;
  ImpedanceOptions options;
  options.rows = rows;
  options.posture = VectorXd::Zero(wrist.arm.joints());
  Impedance control(wrist.arm, wrist.tip, {}, options);
  time_cycles(state, "impedance_cycle " + std::to_string(static_cast<int>(rows)), wrist, [&](const Cycle& c) {
    wrist.state.update(c.q, c.dq);
    wrist.tau = control.update(wrist.state, wrist.wanted, wrist.wrench);
  });
}
BENCHMARK_CAPTURE(impedance_cycle, position, TaskRows::kPosition)->Apply(long_enough);
BENCHMARK_CAPTURE(impedance_cycle, pose, TaskRows::kPose)->Apply(long_enough);

// The whole of JointController and TipController, from encoder positions to torques of the drives.
void joint_controller(benchmark::State& state) {
  Wrist wrist;
  JointControllerOptions options;
  options.cycle.torque = 10.0;
  JointController control(wrist.arm, options);
  Measured measured(wrist.arm.joints());
  JointReference wanted(wrist.arm.joints());
  time_cycles(state, "joint_controller", wrist, [&](const Cycle& c) {
    measured.q = wanted.q = c.q;
    wrist.tau = control.update(measured, wanted, 1e-3);
  });
}
BENCHMARK(joint_controller)->Apply(long_enough);

void tip_controller(benchmark::State& state) {
  Wrist wrist;
  TipControllerOptions options;
  options.tip = wrist.tip;
  options.impedance.rows = TaskRows::kPose;
  options.impedance.posture = VectorXd::Zero(wrist.arm.joints());
  options.cycle.torque = 10.0;
  TipController control(wrist.arm, options);
  Measured measured(wrist.arm.joints());
  time_cycles(state, "tip_controller", wrist, [&](const Cycle& c) {
    measured.q = c.q;
    wrist.tau = control.update(measured, wrist.wanted, 1e-3);
  });
}
BENCHMARK(tip_controller)->Apply(long_enough);

// The other controllers, each with the arm's state that it takes.
void computed_torque_cycle(benchmark::State& state) {
  Wrist wrist;
  const VectorXd ones = VectorXd::Ones(wrist.arm.joints());
  ComputedTorque control(wrist.arm.joints(), {ones, ones});
  JointReference wanted(wrist.arm.joints());
  time_cycles(state, "computed_torque_cycle", wrist, [&](const Cycle& c) {
    wrist.state.update(c.q, c.dq);
    wanted.q = c.dq;
    wrist.tau = control.update(wrist.state, wanted);
  });
}
BENCHMARK(computed_torque_cycle)->Apply(long_enough);

void pd_with_gravity_cycle(benchmark::State& state) {
  Wrist wrist;
  const int n = wrist.arm.joints();
  GravityCompensation gravity(wrist.arm);
  const VectorXd ones = VectorXd::Ones(n);
  JointPid pd({ones, VectorXd::Zero(n), ones}, {ones, {}});
  const VectorXd q = VectorXd::Zero(n), dq = q;
  time_cycles(state, "pd_with_gravity_cycle", wrist, [&](const Cycle& c) {
    pd.torques(c.q, c.dq, q, dq, 1e-3, wrist.tau);
    wrist.tau += gravity.update(c.q);
  });
}
BENCHMARK(pd_with_gravity_cycle)->Apply(long_enough);

// Two arms that carry an object between them with a force sensor at the first.
void cooperative_cycle(benchmark::State& state) {
  Wrist wrist;
  CooperativeOptions options;
  options.R_world_arm = {Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity()};
  options.members = {{0, 1, tuned_force_law(2000.0, 1000.0, 40.0), 1.0}};
  CooperativeController control(options, {{0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}});
  CooperativeInput input(2, 1);
  input.position[1] = {0.1, 0.0, 0.0};
  long number = 0;
  control.track(0, true);
  time_cycles(state, "cooperative_cycle", wrist, [&](const Cycle& c) {
    input.force[0].force = 1e-3 * c.q[0];
    input.force[0].number = ++number;
    benchmark::DoNotOptimize(control.update(input).data());
  });
  if (control.state() != CooperativeState::kTracking) state.SkipWithError(describe(control.state()));
}
BENCHMARK(cooperative_cycle)->Apply(long_enough);

void teleoperation_cycle(benchmark::State& state) {
  Wrist wrist;
  Teleoperation control({}, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  control.clutch(true);
  time_cycles(state, "teleoperation_cycle", wrist, [&](const Cycle& c) {
    control.update(c.q.head<3>(), c.dq.head<3>(), c.dq.tail<3>());
    benchmark::DoNotOptimize(control.leader_force().data());
  });
}
BENCHMARK(teleoperation_cycle)->Apply(long_enough);

void gravity_cycle(benchmark::State& state) {
  Wrist wrist;
  GravityCompensation control(wrist.arm);
  time_cycles(state, "gravity_cycle", wrist, [&](const Cycle& c) { wrist.tau = control.update(c.q); });
}
BENCHMARK(gravity_cycle)->Apply(long_enough);

void friction_cycle(benchmark::State& state, FrictionRule rule) {
  Wrist wrist;
  FrictionOptions options;
  options.rule = rule;
  FrictionCompensation friction(wrist.arm, options);
  AdaptiveFrictionOptions adapting;
  adapting.enabled = true;
  AdaptiveFriction adaptive(friction, adapting);
  ModelErrorObserver error(wrist.arm.joints(), {10.0, VectorXd::Ones(wrist.arm.joints())});
  time_cycles(state, "friction_cycle " + std::to_string(static_cast<int>(rule)), wrist, [&](const Cycle& c) {
    wrist.state.update(c.q, c.dq);
    wrist.tau = friction.update(wrist.state, c.dq, c.q, 1e-3);
    wrist.tau += error.update(wrist.state, c.q, 1e-3);
    adaptive.update(wrist.state, error.missing(), 1e-3, friction);
  });
}
BENCHMARK_CAPTURE(friction_cycle, velocity, FrictionRule::kVelocity)->Apply(long_enough);
BENCHMARK_CAPTURE(friction_cycle, stick_slip, FrictionRule::kStickSlip)->Apply(long_enough);
BENCHMARK_CAPTURE(friction_cycle, presliding, FrictionRule::kPresliding)->Apply(long_enough);

void interpolation_cycle(benchmark::State& state) {
  Wrist wrist;
  QuinticInterpolator way(VectorXd::Ones(wrist.arm.joints()));
  VelocityObserver velocity(wrist.arm.joints());
  time_cycles(state, "interpolation_cycle", wrist, [&](const Cycle& c) {
    way.move_to(c.q, 0.5);
    way.advance(0.1);
    wrist.tau = velocity.update(c.q, c.dq, 1e-3);
  });
}
BENCHMARK(interpolation_cycle)->Apply(long_enough);

void inverse_kinematics_step(benchmark::State& state) {
  Wrist wrist;
  InverseKinematicsOptions options;
  options.rows = TaskRows::kPose;
  InverseKinematics inverse(wrist.arm, wrist.tip, options);
  VectorXd q = wrist.cycles.front().q;
  wrist.state.update(q, wrist.tau);
  const Eigen::Vector3d position = wrist.state.tip().position();
  const Eigen::Matrix3d rotation = wrist.state.tip().rotation();
  time_cycles(state, "inverse_kinematics_step", wrist, [&](const Cycle& c) {
    q = wrist.cycles.front().q;
    q += 1e-3 * c.dq;  // where a cycle of motion leaves it
    inverse.solve(position, rotation, q);
  });
}
BENCHMARK(inverse_kinematics_step)->Apply(long_enough);

}  // namespace
}  // namespace veridyn
