#include "held_object.hpp"

namespace veridyn {
namespace {

using Eigen::Vector3d;

Vector3d mean_grasp_point(const ScenarioBody& body, const std::vector<Vector3d>& tips) {
  Vector3d sum = Vector3d::Zero();
  for (const ScenarioBody::Grasp& g : body.grasps) sum += tips[g.arm];
  return sum / static_cast<double>(body.grasps.size());
}

}  // namespace

HeldObject::HeldObject(const ScenarioBody& body, const std::vector<Vector3d>& tips,
                       const Vector3d& gravity, double hand_stiffness)
    : body_(body),
      hand_stiffness_(hand_stiffness),
      positions_(body.grasps.size(), Vector3d::Zero()),
      velocities_(positions_) {
  const Vector3d centre = mean_grasp_point(body, tips);
  wanted_.position = centre;
  if (body.impedance_stiffness <= 0.0) return;
  ObjectImpedanceOptions o;
  o.mass = body.mass;
  o.inertia = body.inertia;
  o.gravity = gravity;
  for (const ScenarioBody::Grasp& g : body.grasps)
    o.grasps.push_back(tips[g.arm] - centre);
  o.wanted_mass = body.wanted_mass;
  o.damping = body.impedance_damping;
  o.stiffness = body.impedance_stiffness;
  o.wanted_inertia = body.wanted_inertia;
  o.angular_damping = body.angular_damping;
  o.angular_stiffness = body.angular_stiffness;
  impedance_ = std::make_unique<ObjectImpedance>(o);
  if (body.grasps.size() > 1) impedance_->set_internal_force(0, 1, body.internal_force);
  impedance_->reset(wanted_);
}

HeldBody HeldObject::in_world(const ScenarioBody& body, const std::vector<Vector3d>& tips,
                              const std::vector<Attachment>& held_by) {
  HeldBody out;
  out.mass = body.mass;
  out.inertia = body.inertia;
  out.position = mean_grasp_point(body, tips);
  for (const ScenarioBody::Grasp& g : body.grasps) {
    HeldBody::Grasp grasp;
    grasp.held_by = held_by[g.arm];
    grasp.point_body = tips[g.arm] - out.position;
    grasp.stiffness = g.stiffness;
    grasp.damping = g.damping;
    out.grasps.push_back(grasp);
  }
  return out;
}

void HeldObject::update(const CooperativeController& motion, const CooperativeInput& input,
                        std::vector<TipTarget>& targets) noexcept {
  wanted_.position.setZero();
  wanted_.velocity.setZero();
  wanted_.acceleration.setZero();
  const double share = 1.0 / static_cast<double>(body_.grasps.size());
  for (size_t k = 0; k < body_.grasps.size(); ++k) {
    const auto arm = static_cast<size_t>(body_.grasps[k].arm);
    wanted_.position += share * targets[arm].motion;
    wanted_.velocity += share * targets[arm].velocity;
    wanted_.acceleration += share * targets[arm].acceleration;
    positions_[k] = input.position[arm];
    velocities_[k] = input.velocity[arm];
  }
  if (!impedance_) return;
  wanted_.rotation = motion.rotation();
  wanted_.spin = motion.spin();
  wanted_.spin_rate = motion.spin_rate();
  const std::vector<TipTarget>& hands =
      impedance_->update(impedance_->estimate(positions_, velocities_), wanted_, Vector3d::Zero(),
                         Vector3d::Zero());
  for (size_t k = 0; k < body_.grasps.size(); ++k) {
    TipTarget& target = targets[body_.grasps[k].arm];
    target = hands[k];
    target.position += target.force / hand_stiffness_;
  }
}

}  // namespace veridyn
