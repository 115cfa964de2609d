#include "veridyn/simulation/simulate_recording.hpp"

#include <cmath>

#include "plant_torques.hpp"
#include "recorded.hpp"
#include "veridyn/math/require.hpp"
#include "math/zero_phase_filter.hpp"
#include "veridyn/simulation/control_loop.hpp"

namespace veridyn {
namespace {

void check(const Model& arm, const MotionSamples& wanted, const SimulationOptions& options) {
  const Eigen::Index rows = wanted.rows();
  const Eigen::Index n = arm.joints();
  const auto fits = [&](const MatrixXd& m) { return m.rows() == rows && m.cols() == n; };
  require(rows >= 1, "simulation: the motion has no rows.");
  require(wanted.q.cols() == n, "simulation: the motion has ", wanted.q.cols(),
          " joints, but arm '", arm.name(), "' has ", n, ".");
  require(wanted.time.size() == rows && fits(wanted.dq) && fits(wanted.ddq),
          "simulation: time has ", wanted.time.size(), " entries, dq is ", wanted.dq.rows(), " x ",
          wanted.dq.cols(), " and ddq ", wanted.ddq.rows(), " x ", wanted.ddq.cols(), ", but q is ",
          rows, " x ", n, ".");
  require(wanted.time.allFinite() && wanted.q.allFinite() && wanted.dq.allFinite() &&
              wanted.ddq.allFinite(),
          "simulation: found a gap or a number that is not finite in the motion, expected none.");
  for (Eigen::Index k = 1; k < rows; ++k) {
    require(wanted.time[k] > wanted.time[k - 1], "simulation: time in row ", k, " is ",
            wanted.time[k], " s, expected more than ", wanted.time[k - 1], " s, the row before.");
  }
  require(options.substeps >= 1, "simulation: found ", options.substeps,
          " substeps, expected at least one.");
}

}  // namespace

void record(const Model& arm, const PerturbedArm& plant, const SimulationOptions& options,
            SimulatedRecording& out) {
  out.measured = out.actual;
  out.tau = out.actual_tau;
  plant.sensors.add_errors(out.actual.time, out.measured.q, out.tau);
  measure(arm, options.noise, options.seed, out.measured, out.tau);
}

SimulatedRecording simulate_recording(const Model& arm, const MotionSamples& wanted,
                                      const SimulationOptions& options) {
  check(arm, wanted, options);
  const PerturbedArm plant = inject_effects(arm, options.hidden);
  const MotionSamples actual = with_tracking_deviation(arm, wanted, options.noise, options.seed);
  SimulatedRecording out{plant.arm, plant.effects,
                         actual,    plant_torques(plant.arm, actual, options.substeps),
                         actual,    {}};
  for (const PerturbedArm::Contact& contact : plant.contacts) {
    for (Eigen::Index k = 0; k < wanted.rows(); ++k) {
      out.actual_tau(k, contact.joint.value) +=
          contact_effort(contact, wanted.time[k] - wanted.time[0]);
    }
  }
  record(arm, plant, options, out);
  return out;
}

MotionSamples with_derivatives(const MotionSamples& given) {
  MotionSamples out = given;
  if (out.dq.size() > 0 && out.ddq.size() > 0) return out;
  const Eigen::Index rows = given.rows();
  require(rows >= 5, "simulation: found ", rows,
          " rows of positions alone, expected at least 5 to derive from.");
  const double dt = (given.time[rows - 1] - given.time[0]) / static_cast<double>(rows - 1);
  for (Eigen::Index k = 1; k < rows; ++k) {
    require(std::abs(given.time[k] - given.time[k - 1] - dt) <= 0.01 * dt,
            "simulation: found a time step of ", given.time[k] - given.time[k - 1],
            " s before row ", k, ", expected ", dt, " s in all rows, or dq and ddq in the file.");
  }
  if (out.dq.size() == 0) out.dq = differentiate(out.q, dt);
  if (out.ddq.size() == 0) out.ddq = differentiate(out.dq, dt);
  return out;
}

}  // namespace veridyn
