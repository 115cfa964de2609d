#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>

#include "dvrk/arm_bench.hpp"
#include "dvrk/planar_arm.hpp"
#include "dvrk/rig.hpp"
#include "dvrk/run/arm_run.hpp"
#include "dvrk/run/controllers/model_controller.hpp"
#include "emulator/board_events.hpp"

// A PSM on two emulated boards that moves at up to 94 % of its velocity limits, by a clock that does not
// depend on the machine: the effect of an event on the run, the report, and how far the arm
// goes on. Motors saturate, and the arm has end stops.

namespace veridyn::dvrk {
namespace {

constexpr double kSeconds = 6.0;
constexpr double kFrom = 5.0, kUntil = 9.0;  // [s] of the boards' clock: the motion plays

enum class Law { kPid, kComputedTorque, kImpedance, kGravity };

struct Event {
  double at;  // [s]
  std::function<void(BoardEmulator&)> happen;
};

class Psm {
 public:
  explicit Psm(const RobotConfig& believed = nominal_config(read_arm("PSM1")).robot(""))
      : model(read_model(std::string(VERIDYN_SOURCE_DIR) + "/examples/dvrk/light-psm.yaml")),
        plant(model),
        emulator(Bench::setups(robot)),
        link(emulator),
        load(plant, robot, facts.coupling(), boards_of(robot), Eigen::Vector3d(0.0, 0.0, 0.12)),
        session(link, believed, options(facts)) {
    emulator.attach(&load);
    load.set_end_stops(Eigen::Vector3d(-1.64, -0.956, -0.005), Eigen::Vector3d(1.64, 0.956, 0.245));
  }

  static ArmSessionOptions options(const ArmFacts& facts) {
    ArmSessionOptions all;
    all.actuator_to_joint = facts.coupling();
    return all;
  }

  static MotionSamples swing(const Eigen::Vector3d& amplitude = {0.9, 0.6, 0.09},
                             const Eigen::Vector3d& periods = {2.0, 3.0, 3.0}) {
    constexpr int kRows = 1201;
    MotionSamples m;
    m.time = VectorXd::LinSpaced(kRows, 0.0, kSeconds);
    m.q.resize(kRows, 3);
    m.dq.resize(kRows, 3);
    for (int k = 0; k < kRows; ++k) {
      for (int j = 0; j < 3; ++j) {
        const double w = 2.0 * M_PI * periods[j] / kSeconds;
        m.q(k, j) = (j == 2 ? 0.12 : 0.0) + amplitude[j] * std::cos(w * m.time[k]);
        m.dq(k, j) = -amplitude[j] * w * std::sin(w * m.time[k]);
      }
    }
    return m;
  }

  RunResult run(Law law, const std::vector<Event>& events = {}, const MotionSamples& motion = swing()) {
    link.each = [&, next = std::size_t{0}](double now) mutable {
      for (; next < events.size() && events[next].at <= now; ++next) events[next].happen(emulator);
      watch();
    };
    PidGains gains{VectorXd::Zero(7), VectorXd::Zero(7), VectorXd::Zero(7)};
    for (int j = 0; j < 7; ++j) {
      gains.p[j] = facts.actuators[j].kp;
      gains.d[j] = facts.actuators[j].kd;
    }
    RunOptions how;
    how.approach_speed = 1.0;
    ModelControlOptions control;
    control.law = law == Law::kImpedance ? ControlLaw::kImpedance
                  : law == Law::kGravity ? ControlLaw::kGravity
                                         : ControlLaw::kComputedTorque;
    control.position_steps = session.units().joint_steps();
    ModelController controller(model, gains, largest_torques(session), control);
    const std::atomic<bool> stop{false};
    RunResult out = law == Law::kPid       ? run_motion(session, link, motion, gains, how, stop)
                    : law == Law::kGravity ? run_in_place(session, link, kSeconds, 3, controller, how, stop)
                                           : run_motion(session, link, motion, controller, how, stop);
    link.each = nullptr;
    return out;
  }

  const ArmFacts facts = read_arm("PSM1");
  const RobotConfig robot = nominal_config(facts).robot("");
  Model model;
  Plant plant;
  BoardEmulator emulator;
  WatchedLink link;
  SimulatedArm load;
  ArmSession session;
  bool currents_flow() {
    for (int b = 0; b < 2; ++b)
      for (int c = 0; c < kChannels; ++c)
        if (emulator.board(b).drive(c).bits != 0.0) return true;
    return false;
  }
  double pressed = 0.0;  ///< [s] for which pitch stood still with its largest current, at the longest

 private:
  void watch() {
    const double most = 0.94 * 5242.88 * robot.actuators[1].max_current;
    const bool presses = std::abs(emulator.board(0).drive(1).bits) > most && std::abs(plant.q()[1] - at_) < 0.002;
    if (!presses) {
      since_ = link.now();
      at_ = plant.q()[1];
    }
    pressed = std::max(pressed, link.now() - since_);
  }

  double since_ = 0.0, at_ = 0.0;
};

Event of_reply(double at, ReplyFault fault, int replies = 1, double delay = 0.0) {
  return {at, [=](BoardEmulator& e) {
            e.faults.reply = fault;
            e.faults.replies = replies;
            e.faults.delay = delay;
          }};
}

// The words of --event.
Event parsed_event(const std::string& words, double at) {
  return {at, [words](BoardEmulator& e) { board_events({words + "@0"}, e).front().happen(e); }};
}

TEST(PsmDrills, TheArmMovesAtTheTimesOfTheInjectedEvents) {
  for (const Law law : {Law::kPid, Law::kComputedTorque, Law::kImpedance}) {
    Psm psm;
    double from = 0.0, until = 0.0;
    const RunResult run = psm.run(law, {{kFrom, [&](BoardEmulator&) { from = psm.plant.dq().norm(); }},
                                        {kUntil, [&](BoardEmulator&) { until = psm.plant.dq().norm(); }}});
    EXPECT_TRUE(run.complete) << run.why;
    EXPECT_GT(from, 0.1);
    EXPECT_GT(until, 0.1);
    EXPECT_GT(run.rows.dq.col(0).maxCoeff(), 1.8);
    EXPECT_EQ(psm.session.boards().faults().report(), "");
  }
}

// One reply that is lost, or 9 ms late, wherever the arm moves: nothing has jumped.
TEST(PsmDrills, OneLostOrLateReplyDoesNotEndTheRun) {
  for (const Law law : {Law::kPid, Law::kComputedTorque, Law::kImpedance}) {
    for (const ReplyFault fault : {ReplyFault::kDrop, ReplyFault::kDelay}) {
      Psm psm;
      std::vector<Event> events;
      for (double t = kFrom; t < kUntil; t += 0.11) events.push_back(of_reply(t, fault, 1, 0.009));
      const RunResult run = psm.run(law, events);
      EXPECT_TRUE(run.complete) << run.why;
      EXPECT_GT(psm.session.boards().faults().count(Condition::kLostReplies), 30);
    }
  }
}

// What the page promises: one of a hundred datagrams may be lost in each direction; five are reported.
TEST(PsmDrills, PacketLossIsToleratedUpToOnePercentAndReportedBeyond) {
  for (const double percent : {0.2, 1.0, 5.0}) {
    Psm psm;
    const RunResult run = psm.run(Law::kComputedTorque, {parsed_event("loss=" + std::to_string(percent), 1.0)});
    EXPECT_EQ(run.complete, percent < 2.0) << percent << ": " << run.why;
    EXPECT_GT(psm.session.boards().faults().count(Condition::kLostReplies), 20);
    if (percent > 2.0) {
      EXPECT_EQ(run.why.find("lost or late replies: "), 0U) << run.why;
      EXPECT_EQ(run.power, OffState::kConfirmed);
    }
  }
}

TEST(PsmDrills, AGapInTheRepliesEndsTheRun) {
  Psm psm;
  const RunResult run = psm.run(Law::kComputedTorque, {of_reply(kFrom, ReplyFault::kDrop, 12)});
  EXPECT_EQ(run.why.find("no reply in time"), 0U) << run.why;
}

// 0.3 degrees in one cycle is what a joint makes at 8 rad/s; its limit is 2.
TEST(PsmDrills, APositionJumpSwitchesOffWithinThreeCycles) {
  for (const double degrees : {0.3, -0.3, 5.0}) {
    for (const double at : {kFrom, 5.7, 6.3}) {
      Psm psm;
      const double counts = degrees * M_PI / 180.0 / psm.robot.actuators[1].bits_to_position;
      bool flows = true;
      const RunResult run = psm.run(
          Law::kComputedTorque, {parsed_event("encoder-jump:6.1=" + std::to_string(std::lround(counts)), at),
                                 {at + 3.0 * Rig::kCycle, [&](BoardEmulator&) { flows = psm.currents_flow(); }}});
      EXPECT_EQ(run.why, "safety supervisor: a position that jumped (joint pitch)") << degrees;
      EXPECT_FALSE(flows);
    }
  }
}

struct Ending {
  const char* event;
  const char* why;
  double within;  // [s] until no current flows
};

// Each event ends every law's run with a true word, and the motors are without current soon.
TEST(PsmDrills, EveryFaultEndsTheRunWithItsNameAndLeavesNoCurrent) {
  const std::vector<Ending> endings = {
      {"old", "old replies in the place of new ones (board 6)", 0.004},
      {"ignore-writes:6", "a write had no effect (board 6)", 0.06},
      {"lose-writes", "a write had no effect", 0.04},
      {"silence", "no reply in time", 0.065},
      {"encoder-stuck:6.1", "a pot disagrees with its encoder (board 6, channel 2)", 0.6},
      {"supply-off", "no motor supply: emergency stop, or the supply is off", 0.002},
      {"relay-open:7", "the safety relay is open (board 7)", 0.002},
      {"current:6.1=0.95", "a motor current out of bounds (board 6, channel 2)", 0.01},
  };
  for (const Ending& one : endings) {
    for (const Law law : {Law::kPid, Law::kComputedTorque}) {
      Psm psm;
      std::optional<bool> flows;  // nullopt: the run had ended before
      const RunResult run = psm.run(law, {parsed_event(one.event, kFrom), {kFrom + one.within + Rig::kCycle, [&](BoardEmulator&) {
                                                                       flows = psm.currents_flow();
                                                                     }}});
      EXPECT_FALSE(run.complete);
      EXPECT_EQ(run.why.find(one.why), 0U) << one.event << ": " << run.why;
      EXPECT_FALSE(flows.value_or(psm.currents_flow())) << one.event;
    }
  }
}

// Encoders that were loaded 10 degrees wrong: the motion leads pitch to its end stop. Whatever controls the
// arm notices that it presses. A motion that stays inside is none the wiser, nor is there anything to see.
TEST(PsmDrills, AnArmPressingOnItsEndStopIsSwitchedOff) {
  RobotConfig wrong = nominal_config(read_arm("PSM1")).robot("");
  wrong.actuators[1].volts_to_position.offset -= 10.0 * M_PI / 180.0;
  for (const Law law : {Law::kPid, Law::kComputedTorque, Law::kImpedance}) {
    Psm psm(wrong);
    const RunResult run = psm.run(law, {}, Psm::swing({0.3, 0.85, 0.05}, {2.0, 2.0, 3.0}));
    EXPECT_FALSE(run.complete);
    EXPECT_TRUE(run.why.find("does not move") != std::string::npos || run.why.find("saturated motor") != std::string::npos) << run.why;
    EXPECT_LT(psm.pressed, 0.27);
    EXPECT_EQ(run.power, OffState::kConfirmed);
    EXPECT_FALSE(psm.currents_flow());
  }
  Psm inside(wrong);
  EXPECT_TRUE(inside.run(Law::kPid, {}, Psm::swing({0.3, 0.6, 0.05})).complete);
}

}  // namespace
}  // namespace veridyn::dvrk
