#include <gtest/gtest.h>

#include "dvrk/arm_bench.hpp"
#include "support/malloc_count.hpp"
#include "dvrk/arms/arm_kinematics.hpp"
#include "veridyn/kinematics/kinematics.hpp"

// Code of a control loop does not allocate.

namespace veridyn::dvrk {
namespace {

const char* const kNeedleDriver = "large-needle-driver-400006";

#if VERIDYN_COUNTS_MALLOC

TEST(Allocation, UnitConversionsDoNotAllocate) {
  ArmUnits units(example(), read_arm("PSM1").coupling(kNeedleDriver));
  BoardArmState state(7);
  ArmCommand command(7);
  const std::vector<RawActuator> raw(7);
  const VectorXd tau = VectorXd::Constant(7, 0.01);
  const VectorXd pots = VectorXd::Constant(7, 30000.0);
  VectorXd q(7);
  std::vector<std::uint32_t> words(7);
  const long before = malloc_count();
  units.read(raw.data(), state);
  units.write(tau, command);
  units.write_zero(command);
  units.pot_positions(pots, q);
  units.preload_words(q, words.data());
  EXPECT_EQ(malloc_count(), before);
}

TEST(Allocation, ACycleDoesNotAllocate) {
  Bench bench(example(), read_arm("PSM1").coupling(kNeedleDriver), example_start());
  bench.idle(0.01);
  ASSERT_TRUE(bench.arm.home().done);
  bench.idle(0.01);
  ASSERT_EQ(bench.arm.power_on(), nullptr);
  bench.idle(0.5);
  ASSERT_TRUE(bench.arm.ready());
  const VectorXd tau = VectorXd::Constant(7, 0.01);
  long taken = 0;
  for (int k = 0; k < 100; ++k) {
    bench.link.wait(kCycle);
    const long before = malloc_count();
    bench.arm.update();
    bench.arm.set_torques(tau);
    bench.arm.commit();
    taken += malloc_count() - before;
  }
  EXPECT_EQ(taken, 0);
  EXPECT_GT(bench.load.current.cwiseAbs().minCoeff(), 1e-4);  // it did run
}

TEST(Allocation, KinematicsDoNotAllocate) {
  const PsmKinematics psm(read_arm("PSM1"));
  const MtmKinematics mtm(read_arm("MTML"));
  const PsmKinematics::Joints q6 = PsmKinematics::Joints::Constant(0.1);
  const MtmKinematics::Joints q7 = MtmKinematics::Joints::Constant(0.1);
  const auto tip = [](const char* name, const VectorXd& q) {
    const Model chain = arm_model(read_arm(name));
    return Eigen::Matrix4d(frame_pose(chain, q, *chain.find_frame("tip")).matrix());
  };
  const Eigen::Matrix4d T_psm = tip("PSM1", q6), T_mtm = tip("MTML", q7);
  const long before = malloc_count();
  EXPECT_EQ(psm.inverse(T_psm, q6).status, InverseStatus::kDone);
  EXPECT_EQ(mtm.inverse(T_mtm, q7).status, InverseStatus::kDone);
  EXPECT_EQ(malloc_count(), before);
}

#endif

}  // namespace
}  // namespace veridyn::dvrk
