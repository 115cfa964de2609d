#include "veridyn/dvrk/board_arm.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "dvrk/arm_bench.hpp"
#include "emulator/board_server.hpp"
#include "veridyn/math/require.hpp"

// The public interface to an arm's boards, over sockets and in real time.

namespace veridyn {
namespace {

using namespace dvrk;

class OnBoards : public testing::Test {
 protected:
  OnBoards()
      : robot_(nominal_config(read_arm("PSM1")).robot()),
        load_(robot_, example_start()),
        emulator_(Bench::setups(robot_)),
        server_(emulator_, 0) {
    emulator_.attach(&load_);
    begin();
    options_.port = server_.port();
    options_.watchdog = 0.3;  // a busy machine misses some
    options_.reply_timeout = 0.05;
  }
  ~OnBoards() override { end(); }

  void begin() {
    stop_ = false;
    thread_ = std::thread([this] { server_.run(stop_); });
  }
  void end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

  // Runs cycles until done() is true, for at most 10 s. @returns false if it never was.
  template <typename Work>
  static bool run_until(BoardArm& arm, Work done) {
    for (int k = 0; k < 10000; ++k) {
      const bool ends = arm.read() && done();
      arm.write();
      if (ends) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }

  RobotConfig robot_;
  Inertias load_;
  BoardEmulator emulator_;
  BoardServer server_;
  BoardArmOptions options_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

TEST_F(OnBoards, ATorqueMovesItsJointAndUncommandedJointsAreHeld) {
  BoardArm arm(options_);
  ASSERT_EQ(arm.joints(), 7);
  ASSERT_TRUE(run_until(arm, [] { return true; }));
  const VectorXd start = arm.q();
  EXPECT_FALSE(arm.powered());
  ASSERT_EQ(arm.power_on(), nullptr);
  EXPECT_TRUE(arm.powered());
  VectorXd tau = VectorXd::Zero(3);
  ASSERT_TRUE(run_until(arm, [&] {
    arm.set_torques(tau);
    return arm.ready();
  })) << (arm.fault() != nullptr ? arm.fault() : "no fault");
  tau[1] = 0.2;
  EXPECT_TRUE(run_until(arm, [&] {
    arm.set_torques(tau);
    return arm.q()[1] > start[1] + 0.05;
  }));
  EXPECT_LT((arm.q() - start).tail(4).cwiseAbs().maxCoeff(), 0.005);
  EXPECT_NEAR(arm.tau()[1], 0.2, 0.02);  // as the boards measure their currents
  // A joint without commanded torque is displaced, and returns.
  end();
  load_.q[4] += 0.03;
  begin();
  ASSERT_TRUE(run_until(arm, [&] {
    arm.set_torques(tau);
    return arm.q()[4] > start[4] + 0.02;
  }));
  EXPECT_TRUE(run_until(arm, [&] {
    arm.set_torques(tau);
    return arm.q()[4] < start[4] + 0.005;
  })) << arm.q()[4] - start[4];
  // Without further set_torques() there is no current, though power is on.
  int left = 20;
  EXPECT_TRUE(run_until(arm, [&] { return --left == 0; }));
  EXPECT_LT(arm.tau().cwiseAbs().maxCoeff(), 0.02);
  EXPECT_TRUE(arm.shutdown());
  EXPECT_FALSE(arm.powered());
  end();
  EXPECT_EQ(load_.effort.cwiseAbs().maxCoeff(), 0.0);
}

TEST_F(OnBoards, SilentBoardsAreAFaultAndPowerOffIsNotConfirmed) {
  BoardArm arm(options_);
  ASSERT_TRUE(run_until(arm, [] { return true; }));
  ASSERT_EQ(arm.power_on(), nullptr);
  end();  // the boards are silent from here on
  for (int k = 0; k < 20; ++k) {
    EXPECT_FALSE(arm.read());
    arm.write();
  }
  ASSERT_NE(arm.fault(), nullptr);
  EXPECT_FALSE(arm.ready());
  EXPECT_FALSE(arm.shutdown());  // no board confirms it
}

TEST(BoardArm, NamesTheMissingFileOrArm) {
  BoardArmOptions options;
  options.config = "PSM9";
  EXPECT_THROW(BoardArm{options}, InvalidInput);
  options.config = "PSM1";
  options.instrument = "spoon";
  EXPECT_THROW(BoardArm{options}, InvalidInput);
  options.instrument.clear();
  options.rate = 1.0;
  EXPECT_THROW(BoardArm{options}, InvalidInput);
  options.rate = 1000.0;
  options.port = 9;  // no server listens there
  EXPECT_THROW(BoardArm{options}, InvalidInput);
}

}  // namespace
}  // namespace veridyn
