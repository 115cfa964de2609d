#include "veridyn/simulation/replay.hpp"

#include <cmath>

#include "simulation/plant/plant_forces.hpp"
#include "plant_torques.hpp"
#include "regressor/effect_along.hpp"
#include "veridyn/math/require.hpp"
#include "math/zero_phase_filter.hpp"

namespace veridyn {
namespace {

constexpr Eigen::Index kFewestRows = 10;
// One state per row, as in identification. Loads are low-passed below the cut-off, as there, since effects that
// differentiate them would amplify the noise of the motion.
constexpr int kSubsteps = 1;
constexpr double kCrossover = 0.5;  // [Hz] positions below it and velocities above it are the recorded ones

// A zero-phase low-pass on a grid of this rate [Hz].
class LowPass {
 public:
  LowPass(int order, double rate) : order_(order), rate_(rate) {}

  /// Filters columns with this cut-off [Hz]; 0: no filter.
  MatrixXd operator()(MatrixXd columns, double cutoff) const {
    if (cutoff > 0.0) ZeroPhaseFilter(cutoff, order_, rate_).apply(columns);
    return columns;
  }

 private:
  int order_;
  double rate_;
};

// Norm of the difference relative to that of `expected`, per joint, over the rows in use.
VectorXd relative_error(const MatrixXd& found, const MatrixXd& expected,
                        const std::vector<char>& use) {
  VectorXd error = VectorXd::Zero(found.cols());
  VectorXd size = error;
  for (Eigen::Index k = 0; k < found.rows(); ++k) {
    if (use[k] == 0) continue;
    error += (found.row(k) - expected.row(k)).cwiseAbs2().transpose();
    size += expected.row(k).cwiseAbs2().transpose();
  }
  return (error.array() / size.array()).sqrt();
}

// Sets motion_rms and motion_max of `out`, over the rows in use.
void compare_motion(const ReplayInput& input, Replay& out) {
  const Eigen::Index n = input.tau.cols();
  out.motion_rms = out.motion_max = VectorXd::Zero(n);
  long count = 0;
  for (Eigen::Index k = 0; k < out.run.motion.rows(); ++k) {
    if (input.use[k] == 0) continue;
    const VectorXd off = (out.run.motion.q.row(k) - input.motion.q.row(k)).transpose();
    out.motion_rms += off.cwiseAbs2();
    out.motion_max = out.motion_max.cwiseMax(off.cwiseAbs());
    ++count;
  }
  out.motion_rms = (out.motion_rms / static_cast<double>(std::max(1L, count))).cwiseSqrt();
}

bool accepts_every_term(const EffectTerm& /*term*/) {
  return true;
}

// The reference with which a PD with these gains gives tau: e = wanted - actual follows de/dt = (tau - p e) /
// d, solved exactly for a torque that is constant over a row.
void reference_from_torques(MotionSamples& wanted, const MatrixXd& tau, const PidGains& gains) {
  for (Eigen::Index i = 0; i < tau.cols(); ++i) {
    const double p = gains.p[i];
    const double d = gains.d[i];
    double e = p > 0.0 ? tau(0, i) / p : 0.0;
    for (Eigen::Index k = 0; k < tau.rows() && p > 0.0; ++k) {
      const double settled = tau(k, i) / p;
      const double h = k + 1 < tau.rows() ? wanted.time[k + 1] - wanted.time[k] : 0.0;
      wanted.q(k, i) += e;
      e = d > 0.0 ? settled + (e - settled) * std::exp(-h * p / d) : settled;
    }
  }
}

// Positions whose low frequencies are recorded and whose high frequencies are those of the integrated velocity:
// jitter in the rows' times makes the derivative of q noisier than dq.
MatrixXd fused_positions(const MotionSamples& m, const LowPass& low_pass) {
  MatrixXd integral = m.q;
  for (Eigen::Index k = 1; k < m.rows(); ++k)
    integral.row(k) =
        integral.row(k - 1) + 0.5 * (m.time[k] - m.time[k - 1]) * (m.dq.row(k) + m.dq.row(k - 1));
  return integral + low_pass(m.q - integral, kCrossover);
}

MotionSamples first_rows(const MotionSamples& m, Eigen::Index rows) {
  return {m.time.head(rows), m.q.topRows(rows), m.dq.topRows(rows), m.ddq.topRows(rows)};
}

}  // namespace

Replay replay(Engine& engine, const Model& arm, const ReplayInput& input,
              const ReplayOptions& options) {
  const Eigen::Index rows = input.motion.rows();
  require(rows >= kFewestRows && input.tau.rows() == rows && input.tau.cols() == arm.joints() &&
              input.use.size() == static_cast<size_t>(rows),
          "replay: found ", rows, " rows of motion, ", input.tau.rows(), " x ", input.tau.cols(),
          " torques and ", input.use.size(), " marks, expected the same rows of ", arm.joints(),
          " joints, ", kFewestRows, " at least.");
  Replay out;
  LoopOptions loop = options.loop;
  if (loop.gains.p.size() == 0) loop.gains = sensible_gains(arm);
  // The set points lie ahead of the motion that they caused, so that an integral term would remove a deviation
  // that is correct.
  if (options.drive == ReplayDrive::kCommands) loop.gains.i.setZero();
  out.gains = loop.gains;
  const double dt =
      (input.motion.time[rows - 1] - input.motion.time[0]) / static_cast<double>(rows - 1);
  const LowPass low_pass(options.order, 1.0 / dt);
  if (options.drive == ReplayDrive::kTorques) {
    out.run = run_with_torques(engine, input.motion, input.tau);
  } else {
    MotionSamples wanted = input.motion;
    wanted.q = low_pass(fused_positions(wanted, low_pass), options.set_point_cutoff);
    if (options.drive == ReplayDrive::kCommands)
      reference_from_torques(wanted, low_pass(input.tau, options.set_point_cutoff), loop.gains);
    // The reference velocity must be the derivative of the reference: a recorded velocity that lags
    // or has a wrong scale would act through the damping as a torque.
    wanted.dq = differentiate(wanted.q, dt);
    loop.start = input.motion.q.row(0).transpose();
    out.run = run_with_pid(engine, arm, wanted, loop);
  }
  const Eigen::Index done = out.run.motion.rows();
  require(done >= kFewestRows, "replay: ", out.run.stop_reason(arm), ", after ", done, " rows.");
  compare_motion(input, out);
  const auto load = [&](const MotionSamples& motion) {
    return low_pass(rigid_torques(arm, motion), kLoadCutoffShare * options.cutoff);
  };
  // A plant cannot include effects of measured motion; they are added to first order, since an elastic
  // transmission moves the arm by less than the controller resolves.
  const MatrixXd unfelt = effect_torques(arm, out.run.motion, load(out.run.motion), kSubsteps,
                                         describes_measured_motion);
  const MotionSamples recorded = first_rows(input.motion, done);
  out.recorded_tau = low_pass(input.tau.topRows(done), options.cutoff);
  out.simulated_tau = low_pass(out.run.tau + unfelt, options.cutoff);
  out.predicted_tau = low_pass(
      rigid_torques(arm, recorded) + effect_torques(arm, recorded, load(recorded), kSubsteps, accepts_every_term),
      options.cutoff);
  out.use.assign(input.use.begin(), input.use.begin() + done);
  out.torque_error = relative_error(out.simulated_tau, out.recorded_tau, out.use);
  out.inverse_error = relative_error(out.predicted_tau, out.recorded_tau, out.use);
  return out;
}

}  // namespace veridyn
