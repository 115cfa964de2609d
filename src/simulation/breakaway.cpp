#include "veridyn/simulation/breakaway.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kStillShare = 0.2;   // of the way that a joint at rest may creep
constexpr double kJumpShare = 5.0;    // ways between two rows: a new start
constexpr double kPeriod = 1e-3;      // [s] of the controller that holds the others
constexpr double kStartsBelow = 0.6;  // of the effort at the onset: a ramp starts low
constexpr double kLonger = 2.0;       // times the recorded ramp that the model is pushed

struct Ramp {
  Eigen::Index rest, onset;
  Eigen::Index end;  // the row after the last one before the next jump
};

// Rests that end in motion.
std::vector<Ramp> ramps_of(const VectorXd& time, const VectorXd& q, double way, double rest) {
  std::vector<Ramp> ramps;
  const Eigen::Index rows = q.size();
  const auto jumps = [&](Eigen::Index k) { return std::abs(q[k] - q[k - 1]) > kJumpShare * way; };
  Eigen::Index start = 0;
  for (Eigen::Index k = 1; k < rows; ++k) {
    const double off = std::abs(q[k] - q[start]);
    const bool rested = time[k] - time[start] >= rest;
    if (jumps(k) || (!rested && off > kStillShare * way)) {
      start = k;
      continue;
    }
    if (off <= way) continue;
    Eigen::Index end = k + 1;
    while (end < rows && !jumps(end)) ++end;
    ramps.push_back({start, k, end});
    start = k;
  }
  return ramps;
}

// The mean of a tenth of a second around row k.
double effort_at(const VectorXd& time, const VectorXd& tau, Eigen::Index k) {
  double sum = 0.0;
  int count = 0;
  for (Eigen::Index i = std::max<Eigen::Index>(0, k - 50); i < std::min(tau.size(), k + 50); ++i) {
    if (std::abs(time[i] - time[k]) > 0.05) continue;
    sum += tau[i];
    ++count;
  }
  return sum / count;
}

double median(std::vector<double> values) {
  values.erase(std::remove_if(values.begin(), values.end(), [](double v) { return std::isnan(v); }),
               values.end());
  if (values.empty()) return kNaN;
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Pushes the model through one ramp. Where the recording has moved on, the effort goes on rising as
// it did on the way to the onset.
class Push {
 public:
  Push(Engine& engine, const ReplayInput& input, const PidGains& gains, int joint)
      : engine_(engine), in_(input), gains_(gains), joint_(joint) {}

  void run(const Ramp& ramp, double way, BreakawayEvent& event, VectorXd& q_out) {
    const VectorXd& time = in_.motion.time;
    const VectorXd home = in_.motion.q.row(ramp.rest).transpose();
    engine_.set_state(home, VectorXd::Zero(home.size()));
    const double length = time[ramp.onset] - time[ramp.rest];
    const double first = effort_at(time, in_.tau.col(joint_), ramp.rest);
    const double slope = (event.recorded - first) / length;
    event.simulated = kNaN;
    Eigen::Index row = ramp.rest;
    VectorXd integral = VectorXd::Zero(home.size());
    VectorXd tau(home.size());
    while (engine_.time() < kLonger * length) {
      const double t = engine_.time();
      while (row + 1 < ramp.onset && time[row + 1] - time[ramp.rest] <= t) ++row;
      if (row < ramp.end) q_out[row] = engine_.q()[joint_];
      for (Eigen::Index i = 0; i < tau.size(); ++i) {
        const double e = home[i] - engine_.q()[i];
        integral[i] += gains_.i[i] * e * kPeriod;
        tau[i] = gains_.p[i] * e + integral[i] - gains_.d[i] * engine_.dq()[i];
      }
      tau[joint_] = t < length ? in_.tau(row, joint_) : event.recorded + slope * (t - length);
      if (engine_.step(tau, kPeriod) != StepStatus::kOk) return;
      if (std::abs(engine_.q()[joint_] - home[joint_]) <= way) continue;
      event.simulated_at = time[ramp.rest] - time[0] + engine_.time();
      event.simulated = t < length ? effort_at(time, in_.tau.col(joint_), row) : tau[joint_];
      return;
    }
  }

 private:
  Engine& engine_;
  const ReplayInput& in_;
  const PidGains& gains_;
  int joint_;
};

}  // namespace

Breakaway breakaway(Engine& engine, const Model& arm, const ReplayInput& input,
                    const BreakawayOptions& options) {
  const int joint = options.joint;
  const Eigen::Index rows = input.motion.rows();
  require(joint >= 0 && joint < arm.joints(), "breakaway: found joint ", joint + 1, ", but arm '",
          arm.name(), "' has ", arm.joints(), ".");
  require(rows >= 2 && input.motion.joints() == arm.joints() && input.tau.rows() == rows &&
              input.tau.cols() == arm.joints(),
          "breakaway: found ", rows, " x ", input.motion.joints(), " positions and ",
          input.tau.rows(), " x ", input.tau.cols(), " efforts, expected rows of ", arm.joints(),
          " joints of both.");
  const bool slides = arm.coordinates()[static_cast<size_t>(joint)].prismatic;
  const double way = options.way > 0.0 ? options.way : slides ? 1e-3 : 1e-2;
  const VectorXd& time = input.motion.time;
  const PidGains gains = sensible_gains(arm);
  Breakaway out;
  out.simulated_q = VectorXd::Constant(rows, kNaN);
  std::vector<double> recorded[2];
  std::vector<double> simulated[2];
  for (const Ramp& ramp : ramps_of(time, input.motion.q.col(joint), way, options.rest)) {
    BreakawayEvent event;
    event.rest_from = time[ramp.rest] - time[0];
    event.recorded_at = time[ramp.onset] - time[0];
    event.direction = input.motion.q(ramp.onset, joint) > input.motion.q(ramp.rest, joint) ? 1 : -1;
    event.recorded = effort_at(time, input.tau.col(joint), ramp.onset);
    const double first = effort_at(time, input.tau.col(joint), ramp.rest);
    if (event.direction * first > kStartsBelow * event.direction * event.recorded) continue;
    Push(engine, input, gains, joint).run(ramp, way, event, out.simulated_q);
    const size_t side = event.direction > 0 ? 0 : 1;
    recorded[side].push_back(event.recorded);
    simulated[side].push_back(event.simulated);
    out.events.push_back(event);
  }
  out.recorded_forward = median(recorded[0]);
  out.recorded_backward = median(recorded[1]);
  out.simulated_forward = median(simulated[0]);
  out.simulated_backward = median(simulated[1]);
  return out;
}

}  // namespace veridyn
