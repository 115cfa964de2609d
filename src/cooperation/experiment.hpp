#pragma once

#include <memory>
#include <vector>

#include "arm_loop.hpp"
#include "veridyn/cooperation/scenario_run.hpp"
#include "veridyn/simulation/world.hpp"

namespace veridyn {

/// A scenario under way: the world, the sensors, the loops, one control period after the other.
class Experiment {
 public:
  Experiment(const Scenario& scenario, const std::string& engine);

  void begin(const ScenarioPhase& phase);
  /// One control period. False where the engine cannot go on.
  bool step();
  /// Row k of the run, of the instant before the step.
  void record(ScenarioRun& run, Eigen::Index k) const;

  World& world() { return *world_; }
  const CooperativeController& controller() const { return *control_; }
  StepStatus status() const { return status_; }
  std::vector<std::string> left_out() const;

 private:
  void add_arm(const ScenarioArm& arm, const std::string& engine, unsigned seed);
  void add_members();
  void command(const ScenarioCommand& c);
  void apply_faults();
  void read_sensors();

  Scenario scenario_;
  std::vector<WorldArm> world_arms_;
  std::vector<Attachment> tips_;
  std::unique_ptr<World> world_;
  std::vector<ArmLoop> loops_;
  std::vector<ForceSensor> sensors_;
  std::vector<ForceSample> samples_;
  std::unique_ptr<CooperativeController> control_;
  std::unique_ptr<CooperativeInput> input_;
  std::vector<TipTarget> targets_;
  std::vector<VectorXd> tau_;
  std::vector<char> limp_, held_;
  std::vector<Eigen::Vector3d> forces_;  // of each tip on the object, as measured
  StepStatus status_ = StepStatus::kOk;
};

}  // namespace veridyn
