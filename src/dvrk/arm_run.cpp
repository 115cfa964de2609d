#include "veridyn/dvrk/arm_run.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "cycle_clock.hpp"
#include "motion_run.hpp"
#include "pid_controller.hpp"
#include "row_keeper.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kSilence = 0.5;        // [s] without a valid read at the end: the boards are gone
constexpr double kIntegralShare = 0.5;  // of the largest torque

// Set points within the soft limits of every actuator whose position they decide alone.
void require_within_limits(const ArmSession& arm, const MotionSamples& motion) {
  const MatrixXd to_actuator = arm.coupling().inverse();
  const Eigen::Index joints = motion.joints();
  for (int i = 0; i < arm.size(); ++i) {
    const ActuatorConfig& a = arm.robot().actuators[static_cast<size_t>(i)];
    const auto row = to_actuator.row(i);
    if (!(a.lower < a.upper) || row.head(joints).isZero() ||
        !row.tail(arm.size() - joints).isZero())
      continue;
    const VectorXd q = motion.q * row.head(joints).transpose();
    require(q.minCoeff() >= a.lower && q.maxCoeff() <= a.upper, "arm '", arm.robot().name,
            "': the motion takes actuator ", i, " from ", q.minCoeff(), " to ", q.maxCoeff(),
            ", expected ", a.lower, " to ", a.upper, " (soft limits).");
  }
}

RunResult run_checked(ArmSession& arm, DatagramLink& link, const MotionSamples& motion,
                      Eigen::Index recorded, MotionController& controller,
                      const RunOptions& options, const std::atomic<bool>& stop) {
  require(options.rate > 0.0, "arm '", arm.robot().name, "': expected a positive rate.");
  require(options.largest_error > 0.0 && options.approach_speed > 0.0, "arm '", arm.robot().name,
          "': expected a positive largest error and approach speed.");
  MotionRun run(arm, link, motion, recorded, controller, options, stop);
  arm.start();
  return run.run();
}

}  // namespace

// As if one motor worked at a time.
VectorXd largest_torques(const ArmSession& arm) {
  const int n = arm.size();
  VectorXd effort(n);
  for (int i = 0; i < n; ++i) {
    const ActuatorConfig& a = arm.robot().actuators[static_cast<size_t>(i)];
    effort[i] = a.max_current / std::abs(a.effort_to_amps);
  }
  const MatrixXd& K = arm.coupling();
  const MatrixXd to_joint = (K.size() == 0 ? MatrixXd::Identity(n, n) : K).inverse().transpose();
  return to_joint.cwiseAbs() * effort;
}

RunResult run_motion(ArmSession& arm, DatagramLink& link, const MotionSamples& motion,
                     MotionController& controller, const RunOptions& options,
                     const std::atomic<bool>& stop) {
  require(motion.rows() >= 2 && motion.joints() >= 1 && motion.joints() <= arm.size(), "arm '",
          arm.robot().name, "': found a motion of ", motion.joints(), " joints and ", motion.rows(),
          " rows, expected 1 to ", arm.size(), " joints and 2 rows.");
  require(motion.dq.rows() == motion.rows() && motion.q.allFinite() && motion.dq.allFinite() &&
              motion.time.allFinite(),
          "arm '", arm.robot().name, "': found gaps in the motion, expected numbers.");
  require_within_limits(arm, motion);
  controller.require_possible(motion);
  return run_checked(arm, link, motion, motion.joints(), controller, options, stop);
}

RunResult run_motion(ArmSession& arm, DatagramLink& link, const MotionSamples& motion,
                     const PidGains& gains, const RunOptions& options,
                     const std::atomic<bool>& stop) {
  require(gains.p.size() == arm.size(), "arm '", arm.robot().name, "': found gains of ",
          gains.p.size(), " joints, expected ", arm.size(), ".");
  PidController pid(gains, kIntegralShare * largest_torques(arm), 1.0 / options.rate);
  return run_motion(arm, link, motion, pid, options, stop);
}

RunResult run_in_place(ArmSession& arm, DatagramLink& link, double seconds, int joints,
                       MotionController& controller, const RunOptions& options,
                       const std::atomic<bool>& stop) {
  require(seconds > 0.0 && std::isfinite(seconds) && joints >= 1 && joints <= arm.size(), "arm '",
          arm.robot().name, "': found ", seconds, " s and ", joints,
          " joints, expected a positive time and 1 to ", arm.size(), " joints.");
  MotionSamples none;
  none.time = Eigen::Vector2d(0.0, seconds);
  none.q = none.dq = MatrixXd(2, 0);
  RunOptions at_once = options;  // there is no way to go first
  at_once.approach_time = 1.0 / options.rate;
  at_once.settle = 0.0;
  return run_checked(arm, link, none, joints, controller, at_once, stop);
}

LoopTiming watch(ArmSession& arm, DatagramLink& link, double seconds, double rate,
                 const std::atomic<bool>& stop, const std::function<void(double)>& each) {
  require(rate > 0.0 && seconds > 0.0, "arm '", arm.robot().name,
          "': expected a positive rate and a positive time.");
  arm.start();
  CycleClock clock(link, rate);
  const double start = link.now();
  while (!stop.load(std::memory_order_relaxed)) {
    const double t = clock.begin() - start;
    if (t > seconds) break;
    if (arm.update()) each(t);
    arm.commit();
    clock.end();
  }
  return clock.timing();
}

RunResult record_at_rest(ArmSession& arm, DatagramLink& link, double seconds, double rate,
                         const std::atomic<bool>& stop) {
  require(rate > 0.0 && seconds > 0.0, "arm '", arm.robot().name,
          "': expected a positive rate and a positive time.");
  RowKeeper keeper(arm.size(), seconds, rate);
  RunResult result;
  result.timing =
      watch(arm, link, seconds, rate, stop, [&](double t) { keeper.keep(t, arm.state()); });
  result.complete = !stop.load(std::memory_order_relaxed);
  if (!result.complete) result.why = "stopped by a signal";
  result.rows = keeper.take(arm.size());
  const Eigen::Index rows = result.rows.rows();
  const double last = rows > 0 ? result.rows.time[rows - 1] : 0.0;
  if (result.complete && seconds - last > kSilence) {
    result.complete = false;
    result.why = text("no valid read after ", last, " s");
  }
  return result;
}

}  // namespace veridyn::dvrk
