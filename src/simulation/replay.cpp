#include "veridyn/simulation/replay.hpp"

#include <cmath>

#include "plant_forces.hpp"
#include "plant_torques.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/math/zero_phase_filter.hpp"

namespace veridyn {
namespace {

constexpr Eigen::Index kFewestRows = 10;
// As identification builds its columns: one state per row.
constexpr int kSubsteps = 1;

// Relative size of the difference, per joint, over the rows in use.
VectorXd relative_error(const MatrixXd& found, const MatrixXd& expected,
                        const std::vector<char>& use) {
  VectorXd error = VectorXd::Zero(found.cols());
  VectorXd size = error;
  for (Eigen::Index k = 0; k < found.rows(); ++k) {
    if (use[static_cast<size_t>(k)] == 0) continue;
    error += (found.row(k) - expected.row(k)).cwiseAbs2().transpose();
    size += expected.row(k).cwiseAbs2().transpose();
  }
  return (error.array() / size.array()).sqrt();
}

void compare_motion(const ReplayInput& input, Replay& out) {
  const Eigen::Index n = input.tau.cols();
  out.motion_rms = out.motion_max = VectorXd::Zero(n);
  long count = 0;
  for (Eigen::Index k = 0; k < out.run.motion.rows(); ++k) {
    if (input.use[static_cast<size_t>(k)] == 0) continue;
    const VectorXd off = (out.run.motion.q.row(k) - input.motion.q.row(k)).transpose();
    out.motion_rms += off.cwiseAbs2();
    out.motion_max = out.motion_max.cwiseMax(off.cwiseAbs());
    ++count;
  }
  out.motion_rms = (out.motion_rms / static_cast<double>(std::max(1L, count))).cwiseSqrt();
}

// What effects of measured motion, which a plant does not have, add to the torques along a motion:
// to first order, the elastic transmission moves the arm by less than the controller can tell.
MatrixXd measured_motion_torques(const Model& arm, const MotionSamples& motion) {
  const MatrixXd rigid = rigid_torques(arm, motion);
  MatrixXd tau = MatrixXd::Zero(motion.rows(), motion.joints());
  for (const EffectTerm& term : arm.effects()) {
    if (!describes_measured_motion(term)) continue;
    const BoundEffect effect(arm, term);
    const Eigen::Map<const VectorXd> values(effect.values().data(), effect.parameter_count());
    tau += effect_columns(arm, term, motion, rigid, kSubsteps) * values *
           term.axis.coefficients.transpose();
  }
  return tau;
}

// The motion that a PD of these gains was asked for when it gave tau: e = wanted - actual follows
// de/dt = (tau - p e) / d, solved exactly for a torque that is constant over a row.
MotionSamples commands(const MotionSamples& actual, const MatrixXd& tau, const PidGains& gains) {
  MotionSamples wanted = actual;
  for (Eigen::Index i = 0; i < tau.cols(); ++i) {
    const double p = gains.p[i];
    const double d = gains.d[i];
    double e = p > 0.0 ? tau(0, i) / p : 0.0;
    for (Eigen::Index k = 0; k < tau.rows() && p > 0.0; ++k) {
      const double settled = tau(k, i) / p;
      wanted.q(k, i) += e;
      if (d > 0.0) wanted.dq(k, i) += (tau(k, i) - p * e) / d;
      const double h = k + 1 < tau.rows() ? actual.time[k + 1] - actual.time[k] : 0.0;
      e = d > 0.0 ? settled + (e - settled) * std::exp(-h * p / d) : settled;
    }
  }
  return wanted;
}

MotionSamples first_rows(const MotionSamples& m, Eigen::Index rows) {
  return {m.time.head(rows), m.q.topRows(rows), m.dq.topRows(rows), m.ddq.topRows(rows)};
}

}  // namespace

Replay replay(Engine& engine, const Model& arm, const ReplayInput& input,
              const ReplayOptions& options) {
  const Eigen::Index rows = input.motion.rows();
  require(input.tau.rows() == rows && input.tau.cols() == arm.joints() &&
              input.use.size() == static_cast<size_t>(rows),
          "replay: found ", rows, " rows of motion, ", input.tau.rows(), " x ", input.tau.cols(),
          " torques and ", input.use.size(), " marks, expected the same rows of ", arm.joints(),
          " joints.");
  Replay out;
  LoopOptions loop = options.loop;
  if (loop.gains.p.size() == 0) loop.gains = sensible_gains(arm);
  // An integral would bring the motion to the commands, which lie ahead of it.
  if (options.drive == ReplayDrive::kCommands) loop.gains.i.setZero();
  out.gains = loop.gains;
  const double rate =
      static_cast<double>(rows - 1) / (input.motion.time[rows - 1] - input.motion.time[0]);
  const auto low_passed = [&](MatrixXd tau, double cutoff) {
    if (cutoff > 0.0) ZeroPhaseFilter(cutoff, options.order, rate).apply(tau);
    return tau;
  };
  if (options.drive == ReplayDrive::kTorques) {
    out.run = run_with_torques(engine, input.motion, input.tau);
  } else if (options.drive == ReplayDrive::kSetPoints) {
    out.run = run_with_pid(engine, arm, input.motion, loop);
  } else {
    const MatrixXd tau = low_passed(input.tau, options.set_point_cutoff);
    out.run = run_with_pid(engine, arm, commands(input.motion, tau, loop.gains), loop);
  }
  const Eigen::Index done = out.run.motion.rows();
  require(done >= kFewestRows, "replay: ", out.run.why(arm), ", after ", done, " rows.");
  compare_motion(input, out);
  const MatrixXd recorded = low_passed(input.tau.topRows(done), options.cutoff);
  const MatrixXd simulated =
      low_passed(out.run.tau + measured_motion_torques(arm, out.run.motion), options.cutoff);
  const MatrixXd predicted =
      low_passed(plant_torques(arm, first_rows(input.motion, done), kSubsteps), options.cutoff);
  const std::vector<char> use(input.use.begin(), input.use.begin() + done);
  out.torque_error = relative_error(simulated, recorded, use);
  out.inverse_error = relative_error(predicted, recorded, use);
  return out;
}

}  // namespace veridyn
