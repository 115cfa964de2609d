#pragma once

#include <string>
#include <vector>

#include "veridyn/math/require.hpp"
#include "veridyn/model/joint_sensors.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/hidden_effect.hpp"
#include "veridyn/simulation/plant.hpp"
#include "veridyn/simulation/plausible_model.hpp"

/// A simulated da Vinci arm in place of a real one: it moves by its true dynamics, with effects that its
/// model lacks. Encoders have steps; torques last for a cycle.
class SimulatedRobot {
 public:
  static constexpr double kCycle = 0.001;  // [s]

  /// @param unknown  effects that the MODEL lacks, as `veridyn simulate --effect`: "payload:tool:mass=0.1".
  explicit SimulatedRobot(const std::vector<std::string>& unknown = {},
                          const veridyn::VectorXd& start = Eigen::Vector3d(0.1, 0.05, 0.12))
      : real_(make(unknown)), plant_(real_.arm), tau_(start), push_(veridyn::VectorXd::Zero(start.size())) {
    plant_.set_state(start, push_);
  }

  /// Encoder readings [rad], [m].
  void read(veridyn::VectorXd& q) {
    q = plant_.q();
    real_.sensors.add_position_errors(q);
    q = (q / kEncoderStep).array().round() * kEncoderStep;
  }

  /// Torques of the drives [N m], [N], for a cycle. @throws InvalidInput  the simulation cannot continue.
  void write(const veridyn::VectorXd& tau) {
    tau_ = tau;
    real_.sensors.correct_torques(tau_);
    tau_ += push_;
    veridyn::require(plant_.step(tau_, kCycle) == veridyn::StepStatus::kOk, "the simulated arm cannot go on");
  }

  /// Sets the torques of external forces on the joints.
  void push(const veridyn::VectorXd& tau) { push_ = tau; }

  /// True joint positions, unknown for a real arm.
  const veridyn::VectorXd& true_q() const { return plant_.q(); }

 private:
  static constexpr double kEncoderStep = 2e-6;
  static veridyn::PerturbedArm make(const std::vector<std::string>& unknown) {
    std::vector<veridyn::HiddenEffect> hidden;
    for (const std::string& one : unknown) hidden.push_back(veridyn::parse_hidden_effect(one));
    // The same values as in `veridyn simulate psm-3dof`.
    return inject_effects(plausible_model(veridyn::read_model("psm-3dof"), 1).arm, hidden);
  }

  veridyn::PerturbedArm real_;
  veridyn::Plant plant_;
  veridyn::VectorXd tau_, push_;
};
