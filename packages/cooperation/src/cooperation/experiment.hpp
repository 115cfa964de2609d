#pragma once

#include <memory>
#include <vector>

#include "arm_loop.hpp"
#include "held_object.hpp"
#include "torque_path.hpp"
#include "veridyn/cooperation/scenario_run.hpp"
#include "veridyn/model/joint_sensors.hpp"
#include "veridyn/simulation/world.hpp"

namespace veridyn {

/// A running scenario: the world, the sensors and the loops, advanced by control periods.
class Experiment {
 public:
  Experiment(const Scenario& scenario, const std::string& engine);

  /// Executes the commands of a phase.
  void begin_phase(const ScenarioPhase& phase);
  /// Executes a command; false if the controller refuses it.
  bool execute(const ScenarioCommand& c);
  /// Advances by one control period. False if the engine failed or the simulation diverged.
  bool step();
  /// Stores the instant before the step as row k of the run.
  void record(ScenarioRun& run, Eigen::Index k) const;

  /// Ends all motion and holds the present position.
  void stop() { control_->stop(); }

  World& world() { return *world_; }
  /// Model of the true arm.
  const Model& real(int arm) const { return arms_[arm]; }
  int arms() const { return static_cast<int>(loops_.size()); }
  /// True position of an arm's tip in the world [m].
  Eigen::Vector3d tip(int arm) const { return world_->point(tips_[arm]).position; }
  /// Last torques on an arm [N m], [N].
  const VectorXd& tau(int arm) const { return tau_[arm]; }
  /// Present values of a wall's sensor channels without noise, see wall_channels() [N].
  Eigen::Vector3d wall_channels_now(int wall);
  const CooperativeController& controller() const { return *control_; }
  /// Last measurements of the controller.
  const CooperativeInput& measured_input() const { return *input_; }
  StepStatus status() const { return status_; }
  /// Effects of the models that the simulation of some arm does not support, in words, each once.
  std::vector<std::string> left_out() const;

 private:
  struct Contact {
    double force = 0.0, rate = 0.0;  // [N] force on the tip; [m/s] rate of the depth
    Eigen::Vector3d measured{Eigen::Vector3d::Zero()};  // [N] reading of the force on the tip, in the world
    Eigen::Vector3d filtered{Eigen::Vector3d::Zero()};  // [N] reading after the low-pass, by channel
  };
  void add_arm(std::size_t index, const std::string& engine);
  void add_members();
  void add_walls();
  void add_bodies();
  void make_controller();
  void read_contacts(double now);
  void apply_faults();
  bool is_out_of_range() const;
  void read_sensors();

  Scenario scenario_;
  std::vector<Model> arms_;
  std::vector<WorldArm> world_arms_;
  std::vector<Attachment> tips_;
  std::unique_ptr<World> world_;
  std::vector<ArmLoop> loops_;
  std::vector<JointSensors> shown_, known_;  // true sensor errors; those known to the controller
  std::vector<VectorXd> measured_;
  std::vector<Eigen::Vector3d> starts_;  // initial true positions of the tips in the world [m]
  WorldObjects objects_;
  std::vector<ForceSensor> sensors_;
  std::vector<std::vector<ForceSensor>> wall_sensors_;  // sensors of every wall, one per channel
  std::vector<TipKinematics> true_tips_;
  std::vector<ForceSample> samples_;
  std::vector<double> filtered_;  // readings after their low-pass [N]
  double smoothing_ = 1.0;
  std::vector<Wall> walls_;
  std::vector<Contact> wall_now_;
  std::vector<HeldObject> held_objects_;
  std::vector<TorquePath> paths_;  // delays from commanded to actual torques
  std::unique_ptr<CooperativeController> control_;
  std::unique_ptr<CooperativeInput> input_;
  std::vector<TipTarget> targets_;
  std::vector<VectorXd> tau_;
  std::vector<char> limp_, held_;
  std::vector<Eigen::Vector3d> forces_;  // [N] measured force of each tip on the object, in the world
  StepStatus status_ = StepStatus::kOk;
};

}  // namespace veridyn
