#include <gtest/gtest.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "cooperation/arm_loop.hpp"
#include "support/malloc_count.hpp"
#include "veridyn/control/object_impedance.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/force_sensor.hpp"
#include "veridyn/simulation/plant.hpp"
#include "veridyn/simulation/plausible_model.hpp"
#include "veridyn/simulation/world.hpp"

// One cycle of the loops that hold an object: no memory from the heap, and its time.

namespace veridyn {
namespace {

// The cooperative controller of two arms and the impedance of one of them, a psm-wrist.
struct Cycle {
  Cycle()
      : arm(plausible_model(read_model("psm-wrist"), 1).arm),
        start(VectorXd::Zero(arm.joints())),
        loop(setup()),
        tips{loop.position(), loop.position() + Eigen::Vector3d(0.1, 0.0, 0.0)},
        control(options(), tips),
        input(2, 1) {
    input.position = tips;
    control.set_force(0, 5.0, 1.0);
  }

  ArmLoopSetup setup() {
    start[2] = 0.15;
    ArmLoopSetup s{arm};
    s.tip = {"roll"};
    s.encoder_step = VectorXd::Constant(arm.joints(), 1e-5);
    s.start = start;
    return s;
  }

  static CooperativeOptions options() {
    CooperativeOptions o;
    o.R_world_arm.assign(2, Eigen::Matrix3d::Identity());
    o.leader = 1;
    ForceLaw law;
    law.gain = 0.1;
    law.damping = 0.4;
    law.feed_forward = 1.0 / 300.0;
    o.members = {{1, 0, law, 1.0}};
    return o;
  }

  void run(long k) {
    q = start;
    for (Eigen::Index i = 0; i < q.size(); ++i)
      q[i] += 1e-3 * std::sin(1e-3 * static_cast<double>(k) + static_cast<double>(i));
    loop.measure(q);
    input.position[0] = loop.position();
    input.velocity[0] = loop.velocity();
    input.force[0] = {5.0 + 0.01 * std::sin(0.1 * static_cast<double>(k)), 0.002, k / 2};
    const auto& targets = control.update(input);
    sum += loop.torque(targets[0], targets[0].force)[0];
  }

  Model arm;
  VectorXd start, q;
  ArmLoop loop;
  std::vector<Eigen::Vector3d> tips;
  CooperativeController control;
  CooperativeInput input;
  double sum = 0.0;
};

// Processor time of this thread, which other programs do not affect.
double cpu_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

long cycles() {
  const char* many = std::getenv("VERIDYN_CONTROL_CYCLES");
  return many != nullptr ? std::atol(many) : 200000;
}

// Ten million with VERIDYN_CONTROL_CYCLES=10000000.
TEST(ControlCycle, DoesNotAllocateAndStaysWithinItsTimeLimits) {
  Cycle cycle;
  cycle.q = cycle.start;
  cycle.run(0);
  std::vector<float> times(cycles());
  const long before = malloc_count();
  for (long k = 0; k < cycles(); ++k) {
    const double begun = cpu_us();
    cycle.run(k + 1);
    times[k] = static_cast<float>(cpu_us() - begun);
  }
  EXPECT_EQ(malloc_count(), before);
  EXPECT_TRUE(std::isfinite(cycle.sum));
  EXPECT_EQ(cycle.control.state(), CooperativeState::kTracking) << describe(cycle.control.state());
  std::sort(times.begin(), times.end());
  const auto at = [&](double share) {
    return times[share * static_cast<double>(times.size() - 1)];
  };
  RecordProperty("median_us", std::to_string(at(0.5)));
  RecordProperty("p9999_us", std::to_string(at(0.9999)));
  // Machines differ and others use this one: a bound that only a mistake reaches. The figure is
  // measured with VERIDYN_CONTROL_TIMES=1.
  EXPECT_LT(at(0.5), 100.0F);
  if (std::getenv("VERIDYN_CONTROL_TIMES") != nullptr)
    printf("median %.2f us, 99.99 %% %.2f us, largest %.1f us of %ld cycles\n", at(0.5), at(0.9999),
           times.back(), cycles());
}

TEST(ControlCycle, ObjectImpedanceDoesNotAllocate) {
  ObjectImpedanceOptions o;
  o.mass = 0.5;
  o.inertia = {1e-3, 1e-3, 1e-3};
  o.stiffness = 100.0;
  o.grasps = {{0.05, 0, 0}, {-0.03, 0.05, 0}, {-0.03, -0.05, 0}};
  ObjectImpedance control(o);
  const std::vector<Eigen::Vector3d> v(3, Eigen::Vector3d::Zero());
  const ObjectMotion wanted;
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  control.set_internal_force(0, 1, 3.0);
  const long before = malloc_count();
  double sum = 0.0;
  for (int k = 0; k < 1000; ++k) {
    const ObjectMotion& now = control.estimate(o.grasps, v);
    sum += control.update(now, wanted, none, none)[0].force.z();
  }
  EXPECT_EQ(malloc_count(), before);
  EXPECT_TRUE(std::isfinite(sum));
}

// The simulated world and its sensors are part of hardware-in-the-loop tests: no memory either.
TEST(ControlCycle, AWorldStepDoesNotAllocate) {
  const Model arm = plausible_model(read_model("psm-3dof"), 1).arm;
  std::vector<WorldArm> arms;
  arms.push_back({arm, std::make_unique<Plant>(arm)});
  arms.push_back({arm, std::make_unique<Plant>(arm), Eigen::Isometry3d(Eigen::Translation3d(0.1, 0.0, 0.0))});
  Member spring;
  spring.name = "spring";
  spring.from = {0, *arm.find_frame("tool"), {0, 0, 0}};
  spring.to = {1, *arm.find_frame("tool"), {0, 0, 0}};
  spring.stiffness = 20000.0;
  spring.damping = 5.0;
  spring.rest_length = 0.0999;
  World world(std::move(arms), {{spring}, {}, {}});
  ForceSensor sensor({500.0, 0.002, 0.01});
  const std::vector<VectorXd> tau(2, VectorXd::Zero(3));
  const long before = malloc_count();
  double sum = 0.0;
  for (int k = 0; k < 200; ++k) {
    ASSERT_EQ(world.step(tau, 1e-3), StepStatus::kOk);
    sum += sensor.read(world.time(), world.member(0).tension).force;
  }
  EXPECT_EQ(malloc_count(), before);
  EXPECT_TRUE(std::isfinite(sum));
}

}  // namespace
}  // namespace veridyn
