#pragma once

#include <string>
#include <utility>
#include <vector>

#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/hidden_effect.hpp"
#include "veridyn/simulation/plausible_model.hpp"
#include "veridyn/simulation/world.hpp"

/// Two simulated da Vinci arms side by side, in place of real ones: their tips hold a spring with a force
/// sensor.
class SimulatedPair {
 public:
  static constexpr double kCycle = 0.001;       // [s]
  static constexpr double kStiffness = 2450.0;  // [N/m] of the spring

  /// @param unknown  effects of the second arm that the MODEL lacks, as `veridyn simulate --effect`.
  explicit SimulatedPair(const std::vector<std::string>& unknown)
      : tau_(2, veridyn::VectorXd::Zero(3)), world_(make(unknown)) {
    for (int a : {0, 1}) world_.set_state(a, Eigen::Vector3d(0.0, 0.05, 0.12), tau_[a]);
  }

  /// Origin of an arm's base in the world [m].
  static Eigen::Vector3d base(int arm) { return {0.12 * arm, 0.0, 0.0}; }
  /// Encoder readings [rad], [m].
  void read(int arm, veridyn::VectorXd& q) const { q = world_.q(arm); }
  /// Reading of the force sensor [N].
  double force() const { return world_.member(0).tension; }
  /// Torques of its drives [N m], [N] for the next cycle.
  void write(int arm, const veridyn::VectorXd& tau) { tau_[arm] = tau; }
  /// One cycle. @throws InvalidInput  the simulation cannot continue.
  void step() {
    veridyn::require(world_.step(tau_, kCycle) == veridyn::StepStatus::kOk, "the simulated arms cannot go on");
  }

 private:
  static veridyn::World make(const std::vector<std::string>& unknown) {
    using namespace veridyn;
    const Model first = plausible_model(read_model("psm-3dof"), 1).arm;
    std::vector<HiddenEffect> hidden;
    for (const std::string& one : unknown) hidden.push_back(parse_hidden_effect(one));
    const Model second = inject_effects(first, hidden).arm;
    std::vector<WorldArm> arms;
    arms.push_back({first, make_engine("veridyn", first)});
    arms.push_back({second, make_engine("veridyn", second)});
    arms[1].T_world_base.translation() = base(1);
    const FrameIndex tool = *first.find_frame("tool");
    Member spring{"spring", {0, tool}, {1, tool}};
    spring.stiffness = kStiffness;
    spring.damping = 2.0;       // [N s/m]
    spring.rest_length = 0.12;  // [m]
    return World(std::move(arms), {{spring}, {}, {}});
  }

  std::vector<veridyn::VectorXd> tau_;
  veridyn::World world_;
};
