#include "veridyn/dvrk/arm_run.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "approach.hpp"
#include "cycle_clock.hpp"
#include "pid_controller.hpp"
#include "row_keeper.hpp"
#include "set_points.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kSilence = 0.5;        // [s] without a valid read at the end: the boards are gone
constexpr double kLooking = 0.1;        // [s] of reading before power is asked for
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

class MotionRun {
 public:
  MotionRun(ArmSession& arm, DatagramLink& link, const MotionSamples& motion, Eigen::Index recorded,
            MotionController& controller, const RunOptions& options, const std::atomic<bool>& stop)
      : arm_(arm),
        link_(link),
        options_(options),
        stop_(stop),
        recorded_(recorded),
        points_(motion),
        controller_(controller),
        keeper_(arm.size(), points_.duration(), options.rate),
        clock_(link, options.rate),
        wanted_(arm.size()),
        tau_(VectorXd::Zero(arm.size())) {}

  RunResult run() {
    const bool done = power_up() && approach() && play();
    RunResult result;
    result.timing = clock_.timing();
    if (done) hold(options_.settle);
    power_down();
    result.rows = keeper_.take(recorded_);
    result.complete = done && why_.empty();
    result.why = why_;
    return result;
  }

 private:
  // One cycle; set points were made for this time. @returns false: the run is over.
  template <typename Make>
  bool cycle(Make&& make) {
    const double now = clock_.begin();
    const bool valid = arm_.update();
    const PowerState state = arm_.boards().state();
    const bool ready = arm_.ready();  // brakes are open as well
    bool sound = true;
    if (valid && ready) {
      make(now);
      sound = control(now);
    }
    if (!ready) forget();
    arm_.commit();  // without torques: without currents
    clock_.end();
    if (!sound) return end(controller_.why());
    if (stop_.load(std::memory_order_relaxed)) return end("stopped by a signal");
    if (state == PowerState::kFault) return end(describe(arm_.boards().cause()));
    return !valid || !ready || follows();
  }

  bool control(double now) noexcept {
    const CycleTimes times{before_ < 0.0 ? 1.0 / options_.rate : now - before_, link_.now() - now};
    before_ = now;
    if (!controller_.torques(arm_.state(), wanted_, times, tau_)) return false;
    arm_.set_torques(tau_);
    return true;
  }

  void forget() noexcept {
    controller_.reset();
    before_ = -1.0;
  }

  bool follows() {
    if (!controller_.follows()) return true;
    Eigen::Index joint = 0;
    const double off = (wanted_.q - arm_.state().q).cwiseAbs().maxCoeff(&joint);
    if (off <= options_.largest_error) return true;
    return end(text("joint ", joint + 1, " is ", off, " off its set point",
                    arm_.command().clipped ? ", with a current at its limit" : ""));
  }

  bool end(const std::string& why) {
    if (why_.empty()) why_ = why;
    return false;
  }

  bool power_up() {
    for (int k = 0; k < static_cast<int>(kLooking * options_.rate); ++k) {
      if (!cycle([](double) {})) return false;
    }
    if (const char* refused = arm_.power_on()) return end(refused);
    for (int k = 0; k < static_cast<int>(options_.power_timeout * options_.rate); ++k) {
      if (!cycle([this](double) { hold_here(); })) return false;
      if (arm_.ready()) return true;
    }
    return end("power does not come up");
  }

  void hold_here() {
    wanted_.q = arm_.state().q;
    rest();
  }

  void rest() {
    wanted_.dq.setZero();
    wanted_.ddq.setZero();
  }

  bool approach() {
    Approach way;
    way.from = way.to = arm_.state().q;
    wanted_.q = way.from;
    points_.at(0.0, wanted_);
    way.to = wanted_.q;
    wanted_.q = way.from;
    rest();
    const double distance = (way.to - way.from).cwiseAbs().maxCoeff();
    way.duration = std::max(options_.approach_time, 1.875 * distance / options_.approach_speed);
    double start = -1.0;
    bool there = false;
    while (!there) {
      const bool goes_on = cycle([&](double now) {
        if (start < 0.0) start = now;
        way.at(now - start, wanted_);
        there = now - start > way.duration + options_.settle;
      });
      if (!goes_on) return false;
    }
    return true;
  }

  bool play() {
    clock_.restart_count();
    controller_.motion_begins();
    const double duration = points_.duration();
    double start = -1.0;
    double t = 0.0;
    LatchTime latch;
    bool kept = false;
    while (t < duration) {
      const bool goes_on = cycle([&](double now) {
        if (start < 0.0) start = now;
        t = now - start;
        points_.at(t, wanted_);
        const double latched = latch.next(now, arm_.board_of(0).seconds());
        keeper_.keep(latched, arm_.state());
        kept = true;
      });
      if (!kept) latch.lost();
      kept = false;
      if (!goes_on) return false;
    }
    return true;
  }

  void hold(double seconds) {
    rest();
    for (int k = 0; k < static_cast<int>(seconds * options_.rate); ++k) {
      if (!cycle([](double) {})) return;
    }
  }

  void power_down() {
    arm_.boards().power_off();
    for (int k = 0; k < 10; ++k) {
      clock_.begin();
      arm_.update();
      arm_.commit();
    }
    if (!arm_.boards().shutdown() && why_.empty())
      why_ = "the boards did not confirm that they are off";
  }

  ArmSession& arm_;
  DatagramLink& link_;
  RunOptions options_;
  const std::atomic<bool>& stop_;
  Eigen::Index recorded_;  // joints
  SetPoints points_;
  MotionController& controller_;
  RowKeeper keeper_;
  CycleClock clock_;
  JointReference wanted_;
  VectorXd tau_;
  double before_ = -1.0;  // [s] when torques were last asked for
  std::string why_;
};

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
