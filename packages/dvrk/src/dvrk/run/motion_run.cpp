#include "motion_run.hpp"

#include <algorithm>

#include "run_end.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

// A smooth path from the arm's position to the start of the motion.
struct Approach {
  VectorXd from, to;
  double duration = 0.0;

  // Set point at t [s] since its begin; at rest outside of its duration.
  void at(double t, JointReference& point) const noexcept {
    const double s = std::clamp(t / duration, 0.0, 1.0);
    const double a = s * s * s * (10.0 - s * (15.0 - 6.0 * s));
    const double da = 30.0 * s * s * (1.0 - s) * (1.0 - s) / duration;
    const double dda = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (duration * duration);
    point.q = from + a * (to - from);
    point.dq = da * (to - from);
    point.ddq = dda * (to - from);
  }
};

constexpr double kLooking = 0.1;       // [s] duration of reading the boards before power-up
constexpr double kLookingAgain = 0.5;  // [s] the same after a stall of the machine
constexpr int kLooks = 6;
constexpr double kLongestGap = 0.5;    // largest gap between two writes, as a share of the watchdog's time
constexpr double kMostLate = 0.05;     // largest share of late cycles, the same as for a whole run

}  // namespace

MotionRun::MotionRun(ArmSession& arm, DatagramLink& link, const MotionSamples& motion,
                     Eigen::Index recorded, MotionController& controller, const MotionCheck& check,
                     const RunOptions& options, const std::atomic<bool>& stop)
    : arm_(arm),
      link_(link),
      options_(options),
      stop_(stop),
      recorded_(recorded),
      points_(motion),
      controller_(controller),
      check_(check),
      keeper_(arm.joints(), points_.duration(), options.rate),
      file_(options.recording, keeper_, recorded),
      clock_(link, options.rate),
      wanted_(arm.joints()),
      tau_(VectorXd::Zero(arm.joints())) {}

RunResult MotionRun::run() {
  const bool done = power_up() && approach() && play();
  RunResult result;
  result.timing = clock_.timing();
  if (done) hold(options_.settle);
  result.power = power_down();
  result.rows = keeper_.extract_rows(recorded_);
  result.why = why_;
  if (latch_.stalled_latches() > 0)
    result.remark = text("the clock of board ", arm_.board_of(0).status.board(),
                         " stood still at ", latch_.stalled_latches(),
                         " rows, whose times are this program's");
  if (result.why.empty()) result.why = objection_to(result.timing);
  finish(file_, result);
  result.complete = result.complete && done && result.power == OffState::kConfirmed;
  return result;
}

// One cycle; set points are those of this time. @returns false: the run is over.
template <typename Make>
bool MotionRun::cycle(Make&& make) {
  const double now = clock_.begin();
  const bool valid = arm_.update();
  clock_.read(arm_.boards().bus().queue_delay());
  const PowerState state = arm_.boards().state();
  const bool ready = arm_.ready();  // brakes are open as well
  bool sound = true;
  if (valid && ready) {
    make(now);
    sound = control();
  }
  if (!ready) reset_controller();
  arm_.commit();  // without torques, so that currents are zero
  clock_.end();
  if (!sound) return end(blind_since_ ? blindness_text(now) : controller_.refusal_reason());
  note_blindness(now, valid);
  if (stop_.load(std::memory_order_relaxed)) return end("stopped by a signal");
  if (state == PowerState::kFault) return end(arm_.boards().cause_text());
  if (clock_.persistently_late() && !looks_) return end(lateness_text(clock_));
  if (file_.failed()) return end("the recording cannot be written");
  return !valid || !ready || (stays_inside() && follows());
}

bool MotionRun::control() noexcept {
  const double now = link_.now();
  const BoardBus::Interval measured = arm_.boards().bus().measured();
  const CycleTimes times{before_ ? now - *before_ : 1.0 / options_.rate,
                         now - measured.from, measured.to - measured.from};
  before_ = now;
  if (!controller_.torques(arm_.state(), wanted_, times, tau_)) return false;
  arm_.set_torques(tau_);
  controller_.set_sent_torques(arm_.command().tau);
  return true;
}

void MotionRun::note_blindness(double now, bool valid) noexcept {
  if (valid) {
    blind_since_.reset();
    return;
  }
  if (!blind_since_) blind_since_ = now;
  const BoardBus& bus = arm_.boards().bus();
  for (int b = 0; b < bus.boards(); ++b)
    if (!bus.valid(b)) blindness_ = bus.loss_reason(b);
}

// The text of a fault that a controller reports after a gap in the reads: the gap is given as the cause.
std::string MotionRun::blindness_text(double now) const {
  return text(describe(blindness_), " for ", 1e3 * (now - *blind_since_), " ms, then ", controller_.refusal_reason());
}

void MotionRun::reset_controller() noexcept {
  controller_.reset();
  before_.reset();
}

bool MotionRun::stays_inside() {
  const int actuator = check_.leaving_actuator(arm_.state());
  if (actuator < 0) return true;
  return end(text("actuator ", actuator,
                  " leaves its soft limits: ", arm_.state().actuator_q[actuator],
                  " with a velocity of ", arm_.state().actuator_dq[actuator]));
}

bool MotionRun::follows() {
  if (!controller_.follows()) return true;
  Eigen::Index joint = 0;
  const VectorXd& most = options_.largest_error;
  const double share = (wanted_.q - arm_.state().q).cwiseAbs().cwiseQuotient(most).maxCoeff(&joint);
  if (share <= 1.0) return true;
  const bool slides = arm_.robot().actuators[joint].prismatic;
  return end(text("joint ", joint + 1, " is ", share * most[joint], slides ? " m" : " rad",
                  " off its set point",
                  arm_.command().clipped ? ", with a current at its limit" : ""));
}

bool MotionRun::end(const std::string& why) {
  if (why_.empty()) why_ = why;
  return false;
}

// Before power-up: checks that this machine and its boards meet the times of the watchdog. One stall is
// tolerated; a machine that stalls repeatedly must not move an arm.
bool MotionRun::check_reads() {
  looks_ = true;
  for (int trial = 0; trial < kLooks; ++trial) {
    clock_.restart_count();
    const int cycles = static_cast<int>((trial == 0 ? kLooking : kLookingAgain) * options_.rate);
    for (int k = 0; k < cycles; ++k) {
      if (!cycle([](double) {})) return false;
    }
    const LoopTiming& seen = clock_.timing();
    const bool slow = seen.longest_gap.seconds > kLongestGap * arm_.watchdog();
    const bool late = static_cast<double>(seen.late) > kMostLate * static_cast<double>(seen.cycles);
    looks_ = slow || late;
    if (!looks_) return true;
    busy_ = text("this machine is too busy, or the boards answer late: ", seen.late, " of ", seen.cycles,
                 " cycles began late, at most ", 1e3 * seen.longest_gap.seconds,
                 " ms passed between two writes, of ",
                 1e3 * arm_.watchdog(), " ms that watchdogs allow; ", describe_reason(seen.longest_gap), ". Nothing was moved");
  }
  return end(busy_);
}

bool MotionRun::power_up() {
  if (!check_reads()) return false;
  const std::string outside = check_.objection_to(arm_.state().q);
  if (!outside.empty()) return end(outside);
  if (const char* refused = arm_.power_on()) return end(refused);
  for (int k = 0; k < static_cast<int>(options_.power_timeout * options_.rate); ++k) {
    if (!cycle([this](double) { hold_position(); })) return false;
    if (arm_.ready()) return true;
  }
  return end("power does not come up");
}

void MotionRun::hold_position() {
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
  way.duration = std::max({options_.approach_time, 1.0 / options_.rate, 1.875 * distance / options_.approach_speed});
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
  bool kept = false;
  while (t < duration) {
    const bool goes_on = cycle([&](double now) {
      if (start < 0.0) start = now;
      t = now - start;
      points_.at(t, wanted_);
      const double latched = latch_.next(now, arm_.board_of(0).seconds());
      keeper_.keep(latched, arm_.state());
      kept = true;
    });
    if (!kept) latch_.mark_gap();
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

OffState MotionRun::power_down() {
  arm_.boards().power_off();
  for (int k = 0; k < 10; ++k) {
    clock_.begin();
    arm_.update();
    arm_.commit();
  }
  return arm_.boards().shutdown();
}

}  // namespace veridyn::dvrk
