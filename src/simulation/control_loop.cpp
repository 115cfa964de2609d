#include "veridyn/simulation/control_loop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "kinematics/motion_limits.hpp"
#include "veridyn/control/joint_controller.hpp"
#include "veridyn/control/quintic_interpolator.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kMostUnderWay = 1e6;  // largest number of delayed positions, all of which are stored
constexpr double kContactRamp = 0.1;  // [s] fade-in and fade-out time of a contact
constexpr double kFar = 10.0;         // largest distance from the set point, in ranges of the joint
constexpr double kStepSeconds = 1.0;  // [s] duration of a joint's step
constexpr double kStepRest = 2.0;     // [s] rest after a step
constexpr double kStepPeriod = 1e-3;  // [s] period of the rows

// Records rows up to the end of the run.
class Log {
 public:
  Log(const VectorXd& time, Eigen::Index n)
      : run_{{time, MatrixXd(time.size(), n), MatrixXd(time.size(), n), MatrixXd(time.size(), n)},
             MatrixXd(time.size(), n)} {}

  // Adds row k, the engine's present state with the motors' torques. Ends the record and returns false if it cannot accelerate.
  bool add_row(Eigen::Index k, Engine& engine, const VectorXd& motors, const VectorXd& all) {
    VectorXd ddq(motors.size());
    const StepStatus status = engine.accelerate(all, ddq);
    if (status != StepStatus::kOk) return stop(k, status, engine);
    run_.motion.q.row(k) = engine.q().transpose();
    run_.motion.dq.row(k) = engine.dq().transpose();
    run_.motion.ddq.row(k) = ddq.transpose();
    run_.tau.row(k) = motors.transpose();
    return true;
  }

  bool stop(Eigen::Index rows, StepStatus status, const Engine& engine) {
    return stop(rows, status, engine, engine.failed_joint());
  }

  // Ends the record before row `rows`; returns false.
  bool stop(Eigen::Index rows, StepStatus status, const Engine& engine, std::optional<JointIndex> joint) {
    run_.status = status;
    run_.stopped_at = engine.time();
    run_.joint = joint;
    run_.motion.time.conservativeResize(rows);
    for (MatrixXd* m : {&run_.motion.q, &run_.motion.dq, &run_.motion.ddq, &run_.tau})
      m->conservativeResize(rows, m->cols());
    return false;
  }

  EngineRun extract_run() { return std::move(run_); }

 private:
  EngineRun run_;
};

// Options for true signals, with limited torques and without supervisor and observer of the model error.
JointControllerOptions controller_options_of(const LoopOptions& options, const VectorXd& limit) {
  JointControllerOptions out{options.gains.p, options.gains.d};
  out.cycle.friction.share = options.friction;
  out.cycle.error_bandwidth = 0.0;
  out.cycle.limits = SafetyLimits();
  out.cycle.limits->torque = limit;
  out.cycle.supervision = Supervision::kLimits;
  out.cycle.signals = Signals::kTrue;
  return out;
}

// The controller and the motors, evaluated once per period.
class Loop {
 public:
  Loop(const Model& arm, const LoopOptions& options)
      : options_(options), n_(arm.joints()), measured_(arm.joints()), limit_(options.drive.limit) {
    if (limit_.size() == 0) {
      limit_ = VectorXd(n_);
      for (Eigen::Index i = 0; i < n_; ++i)
        limit_[i] = arm.coordinates()[i].limits.effort;
    }
    velocity_ = motors_ = whole_ = VectorXd::Zero(n_);
    if (options.model) {
      controller_.emplace(*options.model, controller_options_of(options, limit_));
    } else {
      pid_.emplace(options.gains, PidLimits{{}, limit_});
    }
  }

  void start(const VectorXd& q, const VectorXd& dq) {
    seen_.assign(static_cast<size_t>(std::lround(options_.sensors.delay * options_.rate)) + 1,
                 encoder_reading(q));
    last_ = seen_.front();
    velocity_ = dq;
  }

  // The motors' torques for the next h seconds. A controller with a longer period keeps them for that period.
  const VectorXd& torques(const VectorXd& q, const JointReference& wanted, double h) {
    if (first_ || since_ > 1.0 / options_.rate - 0.5 * h) {
      update(q, wanted, first_ ? h : since_);
      since_ = 0.0;
    }
    since_ += h;
    return motors_;
  }

 private:
  // One cycle of the controller: sets motors_. @param h  [s] since the previous update.
  void update(const VectorXd& q, const JointReference& wanted, double h) {
    std::rotate(seen_.begin(), seen_.begin() + 1, seen_.end());
    seen_.back() = encoder_reading(q);
    const VectorXd& now = seen_.front();
    const double cutoff = options_.sensors.velocity_cutoff;
    const double share = cutoff > 0.0 ? 1.0 - std::exp(-2.0 * M_PI * cutoff * h) : 1.0;
    if (!first_) velocity_ += share * ((now - last_) / h - velocity_);
    first_ = false;
    last_ = now;
    if (controller_) {
      measured_.q = now;
      measured_.dq = velocity_;
      whole_ = controller_->update(measured_, wanted, h);
    } else {
      pid_->torques(now, velocity_, wanted.q, wanted.dq, h, whole_);
    }
    const double follow = options_.drive.lag > 0.0 ? 1.0 - std::exp(-h / options_.drive.lag) : 1.0;
    for (Eigen::Index i = 0; i < n_; ++i) {
      motors_[i] += follow * (quantised(std::clamp(whole_[i], -limit_[i], limit_[i])) - motors_[i]);
    }
  }

  double quantised(double tau) const {
    const double step = options_.drive.step;
    return step > 0.0 ? std::round(tau / step) * step : tau;
  }

  VectorXd encoder_reading(const VectorXd& q) const {
    const VectorXd& step = options_.sensors.encoder_step;
    if (step.size() == 0) return q;
    VectorXd out = q;
    for (Eigen::Index i = 0; i < n_; ++i) {
      if (step[i] > 0.0) out[i] = std::round(q[i] / step[i]) * step[i];
    }
    return out;
  }

  const LoopOptions& options_;
  Eigen::Index n_;
  std::optional<JointController> controller_;  // controller with a model
  std::optional<JointPid> pid_;                // controller without a model
  Measured measured_;
  VectorXd limit_, velocity_, motors_, last_, whole_;
  std::vector<VectorXd> seen_;
  bool first_ = true;
  double since_ = 0.0;  // [s] time since the previous update
};

// Throws InvalidInput if sizes differ or an option is out of range.
void check(const Model& arm, const MotionSamples& m, const LoopOptions& o) {
  const Eigen::Index n = arm.joints();
  const Eigen::Index rows = m.rows();
  require(rows >= 2 && m.q.cols() == n && m.dq.rows() == rows && m.dq.cols() == n &&
              m.time.size() == rows,
          "control loop: found set points of ", rows, " x ", m.q.cols(), " with velocities of ",
          m.dq.rows(), " x ", m.dq.cols(), ", expected at least two rows of ", n, " joints each.");
  for (const VectorXd* gain : {&o.gains.p, &o.gains.i, &o.gains.d}) {
    require(gain->size() == n && gain->allFinite() && gain->minCoeff() >= 0.0,
            "control loop: found gains that are not ", n, " finite numbers, none below zero.");
  }
  require(o.rate > 0.0 && o.drive.lag >= 0.0 && o.drive.step >= 0.0 && o.sensors.delay >= 0.0 &&
              o.sensors.velocity_cutoff >= 0.0,
          "control loop: found a rate that is not above zero, or a lag, step, delay or cut-off "
          "below zero.");
  require(o.sensors.delay * o.rate < kMostUnderWay, "control loop: found ", o.rate, " Hz with a delay of ", o.sensors.delay,
          " s, expected fewer than ", kMostUnderWay, " positions on their way.");
  require(
      o.drive.limit.size() == 0 || (o.drive.limit.size() == n && o.drive.limit.minCoeff() > 0.0),
      "control loop: found torque limits that are not ", n, " numbers above zero.");
  require(!o.model || (o.model->joints() == n && o.friction >= 0.0),
          "control loop: found a model of ", o.model ? o.model->joints() : 0,
          " joints and a share of friction of ", o.friction, ", expected ", n,
          " joints and none below zero.");
  require(o.start.size() == 0 || o.start.size() == n, "control loop: found a start of ",
          o.start.size(), " joints, expected ", n, ".");
}

// The joint that has run away, if any.
std::optional<JointIndex> runaway_joint(const VectorXd& q, const VectorXd& wanted, const VectorXd& range) {
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (std::abs(q[i] - wanted[i]) > kFar * range[i]) return JointIndex{static_cast<int>(i)};
  }
  return std::nullopt;
}

}  // namespace

std::string EngineRun::stop_reason(const Model& arm) const {
  const std::string who =
      joint ? "joint " + arm.coordinates()[joint->value].name : "the arm";
  return fmt::format("stopped at {:.6g} s: {} {}", stopped_at, who, describe(status));
}

double contact_effort(const PerturbedArm::Contact& contact, double t) {
  const double ramp = std::min(kContactRamp, 0.5 * (contact.to - contact.from));
  const double inside = std::min(t - contact.from, contact.to - t);
  if (inside <= 0.0) return 0.0;
  return contact.effort * (inside >= ramp ? 1.0 : 0.5 - 0.5 * std::cos(M_PI * inside / ramp));
}

EngineRun run_with_pid(Engine& engine, const Model& arm, const MotionSamples& set_points,
                       const LoopOptions& options) {
  check(arm, set_points, options);
  const Eigen::Index rows = set_points.rows();
  const VectorXd& time = set_points.time;
  Log log(time, arm.joints());
  JointReference wanted(arm.joints());
  wanted.q = set_points.q.row(0).transpose();
  wanted.dq = set_points.dq.row(0).transpose();
  const VectorXd home = options.start.size() > 0 ? options.start : wanted.q;
  engine.set_state(home, wanted.dq);
  Loop loop(arm, options);
  loop.start(home, wanted.dq);
  const bool accelerations = set_points.ddq.rows() == rows;
  VectorXd all(arm.joints());
  const MotionLimits limits = motion_limits(arm);
  const VectorXd range = limits.upper - limits.lower;
  for (Eigen::Index k = 0; k < rows; ++k) {
    const bool last = k + 1 == rows;
    const double whole = last ? 1.0 / options.rate : time[k + 1] - time[k];
    const int periods = last ? 1 : std::max(1, static_cast<int>(std::lround(whole * options.rate)));
    const double h = whole / periods;
    for (int p = 0; p < periods; ++p) {
      const double u = static_cast<double>(p) / periods;
      const Eigen::Index next = last ? k : k + 1;
      wanted.q = ((1.0 - u) * set_points.q.row(k) + u * set_points.q.row(next)).transpose();
      wanted.dq = ((1.0 - u) * set_points.dq.row(k) + u * set_points.dq.row(next)).transpose();
      if (accelerations)
        wanted.ddq = ((1.0 - u) * set_points.ddq.row(k) + u * set_points.ddq.row(next)).transpose();
      const VectorXd& motors = loop.torques(engine.q(), wanted, h);
      all = motors;
      for (const PerturbedArm::Contact& contact : options.contacts)
        all[contact.joint.value] -= contact_effort(contact, time[k] - time[0] + u * whole);
      if (p == 0 && !log.add_row(k, engine, motors, all)) return log.extract_run();
      if (last) break;
      const StepStatus status = engine.step(all, h);
      if (status != StepStatus::kOk) {
        log.stop(k + 1, status, engine);
        return log.extract_run();
      }
      const std::optional<JointIndex> lost = runaway_joint(engine.q(), wanted.q, range);
      if (!lost) continue;
      log.stop(k + 1, StepStatus::kRanAway, engine, lost);
      return log.extract_run();
    }
  }
  return log.extract_run();
}

MotionSamples joint_steps(const VectorRef& start, const VectorRef& steps) {
  require(start.size() > 0 && start.size() == steps.size(), "joint steps: found ", steps.size(),
          " steps, expected ", start.size(), ", one per joint.");
  const Eigen::Index n = start.size();
  const auto each =
      static_cast<Eigen::Index>(std::lround((kStepSeconds + kStepRest) / kStepPeriod));
  MotionSamples m{VectorXd(n * each), MatrixXd(n * each, n), MatrixXd(n * each, n),
                  MatrixXd(n * each, n)};
  QuinticInterpolator way(start);
  for (Eigen::Index k = 0; k < m.rows(); ++k) {
    const Eigen::Index joint = k / each;
    if (k % each == 0)
      way.move_to(way.goal() + steps[joint] * VectorXd::Unit(n, joint), kStepSeconds);
    m.time[k] = kStepPeriod * static_cast<double>(k);
    m.q.row(k) = way.x().transpose();
    m.dq.row(k) = way.dx().transpose();
    m.ddq.row(k) = way.ddx().transpose();
    way.advance(kStepPeriod);
  }
  return m;
}

EngineRun run_with_torques(Engine& engine, const MotionSamples& motion, const MatrixRef& tau) {
  const Eigen::Index rows = motion.rows();
  require(rows >= 2 && tau.rows() == rows && tau.cols() == engine.joints() &&
              motion.q.cols() == tau.cols() && motion.dq.rows() == rows,
          "replay: found ", rows, " rows of motion and ", tau.rows(), " x ", tau.cols(),
          " torques, expected at least two rows and the same of both.");
  Log log(motion.time, tau.cols());
  engine.set_state(motion.q.row(0).transpose(), motion.dq.row(0).transpose());
  VectorXd now(tau.cols());
  for (Eigen::Index k = 0; k < rows; ++k) {
    now = tau.row(k).transpose();
    if (!log.add_row(k, engine, now, now)) break;
    if (k + 1 == rows) break;
    const StepStatus status = engine.step(now, motion.time[k + 1] - motion.time[k]);
    if (status == StepStatus::kOk) continue;
    log.stop(k + 1, status, engine);
    break;
  }
  return log.extract_run();
}

}  // namespace veridyn
