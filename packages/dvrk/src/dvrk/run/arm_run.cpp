#include "dvrk/run/arm_run.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "cycle_clock.hpp"
#include "motion_check.hpp"
#include "motion_run.hpp"
#include "veridyn/control/joint_pid.hpp"
#include "dvrk/run/controllers/motion_controller.hpp"
#include "dvrk/run/rows/row_file.hpp"
#include "dvrk/run/rows/row_keeper.hpp"
#include "run_end.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

// PID per joint behind the interface of all controllers.
class PidController final : public MotionController {
 public:
  PidController(const PidGains& gains, const VectorXd& integral_limit, double dt)
      : pid_(gains, {integral_limit, {}}), dt_(dt) {}

  void reset() noexcept override { pid_.reset(); }
  bool torques(const BoardArmState& state, const JointReference& wanted, const CycleTimes&,
               VectorXd& tau) noexcept override {
    pid_.torques(state.q, state.dq, wanted.q, wanted.dq, dt_, tau);
    return true;
  }

 private:
  JointPid pid_;
  double dt_;
};

constexpr double kSilence = 0.5;        // [s] without a valid read at the end, after which the boards count as lost
constexpr double kIntegralShare = 0.5;  // share of the largest torque
constexpr double kLargestError = 0.35;  // [rad] default tracking error that ends a run
constexpr double kLargestErrorSliding = 0.02;  // [m] default for a prismatic joint

// Checks options and motion (in positions of the boards), then runs it; records the first `recorded` joints.
RunResult run_checked(ArmSession& arm, DatagramLink& link, const MotionSamples& motion,
                      Eigen::Index recorded, MotionController& controller,
                      const RunOptions& options, const std::atomic<bool>& stop) {
  require(options.rate > 0.0 && std::isfinite(options.rate), "arm '", arm.robot().name,
          "': found a rate of ", options.rate, " Hz, expected a positive number.");
  for (const double seconds : {options.approach_time, options.settle, options.power_timeout})
    require(seconds >= 0.0 && seconds * options.rate < std::numeric_limits<int>::max(), "arm '", arm.robot().name,
            "': found a time of ", seconds, " s to approach, to settle or for power, expected 0 or more.");
  RunOptions all = options;
  if (all.largest_error.size() == 0) all.largest_error = default_largest_errors(arm.robot());
  require(all.largest_error.size() == arm.joints() && (all.largest_error.array() > 0.0).all() &&
              options.approach_speed > 0.0,
          "arm '", arm.robot().name, "': found ", all.largest_error.size(),
          " largest errors, expected ", arm.joints(),
          " positive ones, and a positive approach speed.");
  const MotionCheck check(arm, controller, motion.joints());
  if (motion.joints() > 0) check.require_inside(motion, options.rate);
  MotionRun run(arm, link, motion, recorded, controller, check, all, stop);
  arm.start();
  return run.run();
}

}  // namespace

VectorXd default_largest_errors(const RobotConfig& robot) {
  VectorXd out(robot.size());
  for (int i = 0; i < robot.size(); ++i)
    out[i] =
        robot.actuators[i].prismatic ? kLargestErrorSliding : kLargestError;
  return out;
}

VectorXd largest_torques(const ArmSession& arm) {
  const int n = arm.joints();
  VectorXd effort(n);
  for (int i = 0; i < n; ++i) {
    const ActuatorConfig& a = arm.robot().actuators[i];
    effort[i] = a.max_current / std::abs(a.effort_to_amps);
  }
  const MatrixXd& K = arm.coupling();
  const MatrixXd to_joint = (K.size() == 0 ? MatrixXd::Identity(n, n) : K).inverse().transpose();
  return to_joint.cwiseAbs() * effort;
}

RunResult run_motion(ArmSession& arm, DatagramLink& link, const MotionSamples& motion,
                     MotionController& controller, const RunOptions& options,
                     const std::atomic<bool>& stop) {
  require(motion.rows() >= 2 && motion.joints() >= 1 && motion.joints() <= arm.joints(), "arm '",
          arm.robot().name, "': found a motion of ", motion.joints(), " joints and ", motion.rows(),
          " rows, expected 1 to ", arm.joints(), " joints and 2 rows.");
  require(motion.dq.rows() == motion.rows() && motion.q.allFinite() && motion.dq.allFinite() &&
              motion.time.allFinite(),
          "arm '", arm.robot().name, "': found gaps in the motion, expected numbers.");
  controller.require_possible(motion);
  return run_checked(arm, link, controller.to_board_positions(motion), motion.joints(), controller, options, stop);
}

RunResult run_motion(ArmSession& arm, DatagramLink& link, const MotionSamples& motion,
                     const PidGains& gains, const RunOptions& options,
                     const std::atomic<bool>& stop) {
  require(gains.p.size() == arm.joints(), "arm '", arm.robot().name, "': found gains of ",
          gains.p.size(), " joints, expected ", arm.joints(), ".");
  PidController pid(gains, kIntegralShare * largest_torques(arm), 1.0 / options.rate);
  return run_motion(arm, link, motion, pid, options, stop);
}

RunResult run_in_place(ArmSession& arm, DatagramLink& link, double seconds, int joints,
                       MotionController& controller, const RunOptions& options,
                       const std::atomic<bool>& stop) {
  require(seconds > 0.0 && std::isfinite(seconds) && joints >= 1 && joints <= arm.joints(), "arm '",
          arm.robot().name, "': found ", seconds, " s and ", joints,
          " joints, expected a positive time and 1 to ", arm.joints(), " joints.");
  MotionSamples none;
  none.time = Eigen::Vector2d(0.0, seconds);
  none.q = none.dq = MatrixXd(2, 0);
  RunOptions at_once = options;  // the same options without an approach
  at_once.approach_time = 1.0 / options.rate;
  at_once.settle = 0.0;
  return run_checked(arm, link, none, joints, controller, at_once, stop);
}

namespace {

// Reads until the time is over, the signal arrives, or `each` (of the time [s]) returns false. @returns the reason for
// an early end; empty without one.
std::string watch_while(ArmSession& arm, CycleClock& clock, DatagramLink& link, double seconds,
                        const std::atomic<bool>& stop, const std::function<bool(double)>& each) {
  const double start = link.now();
  while (!stop.load(std::memory_order_relaxed)) {
    const double t = clock.begin() - start;
    if (t > seconds) return "";
    const bool valid = arm.update();
    clock.read(arm.boards().bus().queue_delay());
    const bool goes_on = !valid || each(t);
    arm.commit();
    clock.end();
    if (!goes_on) return "";
    if (clock.persistently_late()) return lateness_text(clock);
  }
  return "stopped by a signal";
}

// Remark on positions with failed encoders, which do not end a run without a driven motor.
std::string encoder_remark(const FaultLog& faults) {
  const FaultEntry& failed = faults[Condition::kEncoder];
  if (failed.count == 0) return "";
  return text("encoders failed ", failed.count, " times (overflow, illegal transition or supply), the last of board ",
              *failed.board, failed.channel ? text(", channel ", *failed.channel + 1) : "",
              ": positions are not to be relied on");
}

// Throws InvalidInput unless time [s] and rate [Hz] are positive.
void require_time(const ArmSession& arm, double seconds, double rate) {
  require(rate > 0.0 && std::isfinite(rate) && seconds > 0.0, "arm '", arm.robot().name,
          "': expected a positive rate and a positive time.");
}

}  // namespace

LoopTiming watch(ArmSession& arm, DatagramLink& link, double seconds, double rate,
                 const std::atomic<bool>& stop, const std::function<void(double)>& each) {
  require_time(arm, seconds, rate);
  arm.start();
  CycleClock clock(link, rate);
  watch_while(arm, clock, link, seconds, stop, [&](double t) {
    each(t);
    return true;
  });
  return clock.timing();
}

RunResult record_at_rest(ArmSession& arm, DatagramLink& link, double seconds, double rate,
                         const std::atomic<bool>& stop, const std::string& recording) {
  require_time(arm, seconds, rate);
  RowKeeper keeper(arm.joints(), seconds, rate);
  RowFile file(recording, keeper, arm.joints());
  RunResult result;
  arm.start();
  CycleClock clock(link, rate);
  result.why = watch_while(arm, clock, link, seconds, stop, [&](double t) {
    keeper.keep(t, arm.state());
    return !file.failed();
  });
  result.timing = clock.timing();
  result.rows = keeper.extract_rows(arm.joints());
  const Eigen::Index rows = result.rows.rows();
  const double last = rows > 0 ? result.rows.time[rows - 1] : 0.0;
  result.remark = encoder_remark(arm.boards().faults());
  if (result.why.empty()) result.why = objection_to(result.timing);
  if (result.why.empty() && !file.failed() && seconds - last > kSilence)
    result.why = text("no valid read after ", last, " s");
  finish(file, result);
  return result;
}

}  // namespace veridyn::dvrk
