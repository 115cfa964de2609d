#include "motion_run.hpp"

#include <algorithm>
#include <cmath>

#include "approach.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kLooking = 0.1;  // [s] of reading before power is asked for

}  // namespace

MotionRun::MotionRun(ArmSession& arm, DatagramLink& link, const MotionSamples& motion,
                     Eigen::Index recorded, MotionController& controller, const RunOptions& options,
                     const std::atomic<bool>& stop)
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

RunResult MotionRun::run() {
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

// One cycle; set points were made for this time. @returns false: the run is over.
template <typename Make>
bool MotionRun::cycle(Make&& make) {
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

bool MotionRun::control(double now) noexcept {
  const CycleTimes times{before_ < 0.0 ? 1.0 / options_.rate : now - before_, link_.now() - now};
  before_ = now;
  if (!controller_.torques(arm_.state(), wanted_, times, tau_)) return false;
  arm_.set_torques(tau_);
  return true;
}

void MotionRun::forget() noexcept {
  controller_.reset();
  before_ = -1.0;
}

bool MotionRun::follows() {
  if (!controller_.follows()) return true;
  Eigen::Index joint = 0;
  const double off = (wanted_.q - arm_.state().q).cwiseAbs().maxCoeff(&joint);
  if (off <= options_.largest_error) return true;
  return end(text("joint ", joint + 1, " is ", off, " off its set point",
                  arm_.command().clipped ? ", with a current at its limit" : ""));
}

bool MotionRun::end(const std::string& why) {
  if (why_.empty()) why_ = why;
  return false;
}

bool MotionRun::power_up() {
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

void MotionRun::hold_here() {
  wanted_.q = arm_.state().q;
  rest();
}

void MotionRun::rest() {
  wanted_.dq.setZero();
  wanted_.ddq.setZero();
}

bool MotionRun::approach() {
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

bool MotionRun::play() {
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

void MotionRun::hold(double seconds) {
  rest();
  for (int k = 0; k < static_cast<int>(seconds * options_.rate); ++k) {
    if (!cycle([](double) {})) return;
  }
}

void MotionRun::power_down() {
  arm_.boards().power_off();
  for (int k = 0; k < 10; ++k) {
    clock_.begin();
    arm_.update();
    arm_.commit();
  }
  if (!arm_.boards().shutdown() && why_.empty())
    why_ = "the boards did not confirm that they are off";
}

}  // namespace veridyn::dvrk
