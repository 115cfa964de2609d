#include "veridyn/simulation/breakaway.hpp"

#include <algorithm>
#include <cmath>

#include "math/median.hpp"
#include "math/numbers.hpp"
#include "recordings/breakaway_ramps.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kPeriod = 1e-3;   // [s] period of the controller that holds the other joints
constexpr double kLonger = 2.0;    // ratio of the longest push of the model to the recorded ramp
constexpr double kSettle = 3.0;    // [s] longest creep before a ramp
constexpr double kHeavy = 3.0;     // damping during the creep, relative to that of a held joint
constexpr double kSettled = 0.02;  // share of the sliding speed below which the joint rests

// Median of the values that are not NaN; NaN if there are none.
double median_of_known(std::vector<double> values) {
  values.erase(std::remove_if(values.begin(), values.end(), [](double v) { return std::isnan(v); }),
               values.end());
  return values.empty() ? kNaN : median(std::move(values));
}

// Applies one ramp to the model. After the recorded onset the effort continues to rise at the same rate.
class Push {
 public:
  Push(Engine& engine, const ReplayInput& input, const PidGains& gains, int joint)
      : engine_(engine), in_(input), gains_(gains), joint_(joint) {}

  // Computes the rows of the ramp; ends when the model slides.
  void run(const Ramp& ramp, double speed, BreakawayEvent& event, Breakaway& out) {
    const VectorXd& time = in_.motion.time;
    const VectorXd home = in_.motion.q.row(ramp.rest).transpose();
    engine_.set_state(home, VectorXd::Zero(home.size()));
    integral_ = VectorXd::Zero(home.size());
    const double length = time[ramp.onset] - time[ramp.rest];
    const double first = effort_at(time, in_.tau.col(joint_), ramp.rest);
    const double slope = (event.recorded - first) / length;
    event.simulated = kNaN;
    if (!creep_to_rest(home, first, speed)) {
      event.simulated = first;
      event.simulated_at = time[ramp.rest] - time[0];
      return;
    }
    const double began = engine_.time();
    const double crept = engine_.q()[joint_] - home[joint_];
    Eigen::Index row = ramp.rest;
    while (engine_.time() - began < kLonger * length) {
      const double t = engine_.time() - began;
      while (row + 1 < ramp.onset && time[row + 1] - time[ramp.rest] <= t) ++row;
      out.simulated_q[row] = engine_.q()[joint_] - crept;
      const double effort =
          t < length ? in_.tau(row, joint_) : event.recorded + slope * (t - length);
      if (!step(home, effort)) return;
      if (std::abs(engine_.dq()[joint_]) <= speed) continue;
      event.simulated_at = time[ramp.rest] - time[0] + engine_.time() - began;
      event.simulated = t < length ? effort_at(time, in_.tau.col(joint_), row) : effort;
      return;
    }
  }

 private:
  // Lets the joint creep, heavily damped, until it rests under the recorded effort, so that
  // friction with memory reaches its recorded state. False if the model does not rest under it.
  bool creep_to_rest(const VectorXd& home, double effort, double speed) {
    while (engine_.time() < kSettle) {
      const double v = engine_.dq()[joint_];
      if (!step(home, effort - kHeavy * gains_.d[joint_] * v)) return false;
    }
    return std::abs(engine_.dq()[joint_]) < kSettled * speed;
  }

  // Advances one period; the other joints are held at home.
  bool step(const VectorXd& home, double effort) {
    VectorXd tau(home.size());
    for (Eigen::Index i = 0; i < tau.size(); ++i) {
      const double e = home[i] - engine_.q()[i];
      integral_[i] += gains_.i[i] * e * kPeriod;
      tau[i] = gains_.p[i] * e + integral_[i] - gains_.d[i] * engine_.dq()[i];
    }
    tau[joint_] = effort;
    return engine_.step(tau, kPeriod) == StepStatus::kOk;
  }

  Engine& engine_;
  const ReplayInput& in_;
  const PidGains& gains_;
  int joint_;
  VectorXd integral_;
};

}  // namespace

Breakaway breakaway(Engine& engine, const Model& arm, const ReplayInput& input,
                    const BreakawayOptions& options) {
  const int joint = options.joint.value;
  const Eigen::Index rows = input.motion.rows();
  require(joint >= 0 && joint < arm.joints(), "breakaway: found joint ", joint + 1, ", but arm '",
          arm.name(), "' has ", arm.joints(), ".");
  require(rows >= 2 && input.motion.joints() == arm.joints() && input.tau.rows() == rows &&
              input.tau.cols() == arm.joints(),
          "breakaway: found ", rows, " x ", input.motion.joints(), " positions and ",
          input.tau.rows(), " x ", input.tau.cols(), " efforts, expected rows of ", arm.joints(),
          " joints of both.");
  RampThresholds limit = ramp_thresholds(arm.coordinates()[joint]);
  if (options.way > 0.0) limit.way = options.way;
  if (options.speed > 0.0) limit.speed = options.speed;
  limit.rest = options.rest;
  const VectorXd& time = input.motion.time;
  const PidGains gains = sensible_gains(arm);
  Breakaway out;
  out.joint = options.joint;
  out.speed = limit.speed;
  out.simulated_q = VectorXd::Constant(rows, kNaN);
  std::vector<double> recorded[2];
  std::vector<double> simulated[2];
  const VectorXd q = input.motion.q.col(joint);
  const VectorXd tau = input.tau.col(joint);
  for (const Ramp& ramp : find_ramps(arm.coordinates()[joint], time, q, tau,
                                     limit)) {
    BreakawayEvent event;
    event.rest_from = time[ramp.rest] - time[0];
    event.recorded_at = time[ramp.onset] - time[0];
    event.direction = q[ramp.onset] > q[ramp.rest] ? 1 : -1;
    event.recorded = effort_at(time, tau, ramp.onset);
    Push(engine, input, gains, joint).run(ramp, limit.speed, event, out);
    const size_t side = event.direction > 0 ? 0 : 1;
    recorded[side].push_back(event.recorded);
    simulated[side].push_back(event.simulated);
    out.events.push_back(event);
  }
  out.recorded_forward = median_of_known(recorded[0]);
  out.recorded_backward = median_of_known(recorded[1]);
  out.simulated_forward = median_of_known(simulated[0]);
  out.simulated_backward = median_of_known(simulated[1]);
  return out;
}

}  // namespace veridyn
