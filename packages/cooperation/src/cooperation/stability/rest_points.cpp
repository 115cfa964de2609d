#include "rest_points.hpp"

#include <cmath>
#include <limits>

#include "cooperation/loop_gains.hpp"
#include "cooperation/phase_commands.hpp"
#include "veridyn/control/task_inverse.hpp"
#include "veridyn/control/tip_kinematics.hpp"

namespace veridyn {
namespace {

using Eigen::Vector3d;

constexpr int kNewtonSteps = 20;
constexpr double kPeriod = 0.01;     // [s] sampling period of the planned motion
constexpr double kNoCheck = 1e9;      // [N] bound so large that the check is off
constexpr double kLeastForce = 1.0;  // [N] contact force on a wall at the equilibrium

// Sets the joints that bring the tip to its target, by Newton steps of the task's own inverse from the
// present ones.
void solve_joints(const Model& model, const ScenarioArm& arm, const Vector3d& wanted_base, VectorXd& q) {
  const Tip tip{arm.frame, arm.offset};
  TipKinematics kinematics(model, tip);
  TaskInverse inverse(model, tip, TaskRows::kPosition);
  const VectorXd rest = VectorXd::Zero(q.size());
  VectorXd step = rest;
  for (int k = 0; k < kNewtonSteps; ++k) {
    kinematics.update(q, rest);
    inverse.update(kinematics.jacobian());
    Vector6d error = Vector6d::Zero();
    error.head<3>() = wanted_base - kinematics.position();
    if (error.norm() < 1e-12) return;
    inverse.solve(error, rest, step);
    q += step;
  }
}

class RestPointSearch {
 public:
  explicit RestPointSearch(const Scenario& scenario) : scenario_(scenario) {
    CooperativeOptions options;
    std::vector<Vector3d> tips;
    for (size_t k = 0; k < scenario.arms.size(); ++k) {
      models_.push_back(scenario_models(scenario, k));
      const ScenarioArm& arm = scenario.arms[k];
      q_.push_back(arm.start);
      TipKinematics tip(models_[k].real, {arm.frame, arm.offset});
      tip.update(arm.start, VectorXd::Zero(arm.start.size()));
      tips.push_back(models_[k].p_world_base + models_[k].R_world_base * tip.position());
      options.R_world_arm.push_back(models_[k].R_world_base);
    }
    options.leader = scenario.master;
    options.period = kPeriod;
    options.drift_force = kNoCheck;  // readings are the wanted forces, independent of the lengths
    for (const ScenarioMember& m : scenario.members)
      options.members.push_back({m.from, m.to, m.law, member_share(scenario, m)});
    control_ = std::make_unique<CooperativeController>(options, tips);
    input_ = std::make_unique<CooperativeInput>(static_cast<int>(tips.size()),
                                                static_cast<int>(scenario.members.size()));
    input_->position = tips;
    held_.assign(scenario.members.size(), 1);
  }

  std::vector<RestPoint> run() {
    for (const ScenarioPhase& phase : scenario_.phases) {
      for (const ScenarioCommand& c : phase.commands) {
        apply_command(c, *control_);
        if (c.kind == ScenarioCommand::Kind::kRelease) held_[c.member] = 0;
        if (c.kind == ScenarioCommand::Kind::kTake) held_[c.member] = 1;
      }
      const auto half = std::max(1L, std::lround(0.5 * phase.duration / kPeriod));
      for (int part = 0; part < 2; ++part) {
        for (long k = 0; k < half; ++k) advance_arms();
        add(phase.name);
      }
    }
    return std::move(points_);
  }

 private:
  // Advances ideal arms that follow exactly by one period; every sensor reads the wanted force.
  void advance_arms() {
    const std::vector<TipTarget>& targets = control_->update(*input_);
    for (size_t k = 0; k < targets.size(); ++k) {
      input_->position[k] = targets[k].motion;
      input_->velocity[k] = targets[k].velocity;
    }
    ++step_;
    for (size_t k = 0; k < held_.size(); ++k)
      input_->force[k] = {control_->wanted_force(static_cast<int>(k)), 0.0, step_};
  }

  // Member k between the present tips; without force if it is released.
  LinearElement member(size_t k) const {
    const ScenarioMember& m = scenario_.members[k];
    const Vector3d line = input_->position[m.to] -
                          input_->position[m.from];
    LinearElement e;
    e.from = m.from;
    e.to = m.to;
    e.length = line.norm();
    e.u = line / e.length;
    e.force = held_[k] != 0 ? control_->wanted_force(static_cast<int>(k)) : 0.0;
    e.attached = held_[k] != 0;
    return e;
  }

  // Appends the equilibrium at the present tips, linearised.
  void add(const std::string& phase) {
    RestPoint point;
    point.phase = phase;
    point.time = kPeriod * static_cast<double>(step_);
    for (size_t k = 0; k < scenario_.members.size(); ++k) point.loop.elements.push_back(member(k));
    for (const ScenarioWall& wall : scenario_.walls) {
      LinearElement e;
      e.to = wall.arm;
      e.u = wall.normal;
      e.length = std::numeric_limits<double>::infinity();
      e.force = -kLeastForce;
      point.loop.elements.push_back(e);
    }
    for (size_t k = 0; k < scenario_.arms.size(); ++k) {
      const ScenarioArm& arm = scenario_.arms[k];
      Vector3d force = Vector3d::Zero();
      for (const LinearElement& e : point.loop.elements) {
        if (e.from == static_cast<int>(k)) force += e.force * e.u;
        if (e.to == static_cast<int>(k)) force -= e.force * e.u;
      }
      solve_joints(models_[k].real, arm,
             models_[k].R_world_base.transpose() * (input_->position[k] - models_[k].p_world_base),
             q_[k]);
      const bool gives = arm.control == ArmControl::kImpedance;
      point.loop.arms.push_back(
          linear_arm(models_[k], arm, q_[k], force, gives ? Vector3d(-force) : Vector3d::Zero()));
    }
    points_.push_back(std::move(point));
  }

  const Scenario& scenario_;
  std::vector<ScenarioModels> models_;
  std::vector<VectorXd> q_;
  std::unique_ptr<CooperativeController> control_;
  std::unique_ptr<CooperativeInput> input_;
  std::vector<char> held_;
  std::vector<RestPoint> points_;
  long step_ = 0;
};

}  // namespace

std::vector<RestPoint> rest_points(const Scenario& scenario) {
  return RestPointSearch(scenario).run();
}

}  // namespace veridyn
