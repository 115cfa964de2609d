#include <Eigen/Geometry>

#include "simulation/world/world_state.hpp"

// Forces of a World's objects, and motion of its bodies.

namespace veridyn {

World::PointMotion World::State::point(const Attachment& at) const {
  if (!at.arm) return {at.offset, Eigen::Vector3d::Zero()};
  const ArmPoints::Point p = arms[*at.arm].points.point(at.frame.value, at.offset);
  return {p.position, p.velocity};
}

void World::State::push(const Attachment& at, const Eigen::Vector3d& force, double share) {
  if (!at.arm) return;
  Arm& arm = arms[*at.arm];
  arm.points.add_force(at.frame.value, at.offset, force, share, arm.external);
}

void World::State::clear_forces() {
  for (Arm& arm : arms) arm.external.setZero();
  for (BodyMotion& body : bodies) body.force = body.moment = Eigen::Vector3d::Zero();
}

void World::State::add_forces(double share, double h) {
  add_members(share, h);
  add_walls(share, h);
  add_bodies(share, h);
}

void World::State::add_members(double share, double h) {
  for (size_t k = 0; k < members.size(); ++k) {
    const Member& m = objects.members[k];
    const PointMotion from = point(m.from);
    const PointMotion to = point(m.to);
    const Eigen::Vector3d line = to.position - from.position;
    MemberState& now = members[k];
    now.length = line.norm();
    const Eigen::Vector3d u =
        now.length > 0.0 ? Eigen::Vector3d(line / now.length) : Eigen::Vector3d::UnitX();
    now.rate = u.dot(to.velocity - from.velocity);
    now.tension = tension(m, now.length, now.rate);
    push(m.from, now.tension * u, share);
    push(m.to, -now.tension * u, share);
    work += share * h * now.tension * now.rate;
  }
}

void World::State::add_walls(double share, double h) {
  for (const Wall& w : objects.walls) {
    const PointMotion p = point(w.touches);
    const Eigen::Vector3d force = contact_force(w, p.position, p.velocity);
    push(w.touches, force, share);
    work -= share * h * force.dot(p.velocity);
  }
}

Eigen::Vector3d World::State::BodyMotion::angular_velocity(const Eigen::Vector3d& principal_moments) const {
  const Eigen::Vector3d in_body = R.transpose() * spin_momentum;
  return R * in_body.cwiseQuotient(principal_moments);
}

void World::State::add_bodies(double share, double h) {
  for (size_t k = 0; k < bodies.size(); ++k) {
    const HeldBody& what = objects.bodies[k];
    BodyMotion& body = bodies[k];
    body.force += share * what.mass * gravity;
    const Eigen::Vector3d spin = body.angular_velocity(what.inertia);
    for (const HeldBody::Grasp& g : what.grasps) {
      if (!g.attached) continue;
      const PointMotion hand = point(g.held_by);
      const Eigen::Vector3d arm = body.R * g.point_body;
      const Eigen::Vector3d force =
          g.stiffness * (hand.position - body.p - arm) +
          g.damping * (hand.velocity - body.v - spin.cross(arm));  // force on the body
      body.force += share * force;
      body.moment += share * arm.cross(force);
      push(g.held_by, -force, share);
      work += share * h * force.dot(hand.velocity);
    }
  }
}

// Predicts the bodies at h after the substep's start from the forces there.
void World::State::predict_bodies(double h) {
  for (size_t k = 0; k < bodies.size(); ++k) {
    const HeldBody& what = objects.bodies[k];
    const BodyMotion& from = start[k];
    BodyMotion& body = bodies[k];
    const Eigen::Vector3d a = rates[k].force / what.mass;
    body.p = from.p + h * from.v + 0.5 * h * h * a;
    body.v = from.v + h * a;
    body.spin_momentum = from.spin_momentum + 0.5 * h * rates[k].moment;
    body.R = from.R;
    const Eigen::Vector3d turn = h * body.angular_velocity(what.inertia);
    if (turn.norm() > 0.0)
      body.R = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * from.R;
    body.spin_momentum = from.spin_momentum + h * rates[k].moment;
  }
}

// Integrates the bodies from the substep's start under the accumulated mean forces.
void World::State::move_bodies(double h) {
  for (size_t k = 0; k < bodies.size(); ++k) {
    rates[k].force = bodies[k].force;
    rates[k].moment = bodies[k].moment;
  }
  predict_bodies(h);
  for (BodyMotion& body : bodies) body.R = Eigen::Quaterniond(body.R).normalized().matrix();
}

Eigen::Vector3d World::grasp_force(int body, int grasp) const {
  const State& s = *state_;
  const State::BodyMotion& b = s.bodies.at(body);
  const HeldBody& what = s.objects.bodies[body];
  const HeldBody::Grasp& g = what.grasps.at(grasp);
  if (!g.attached) return Eigen::Vector3d::Zero();
  const PointMotion hand = s.point(g.held_by);
  const Eigen::Vector3d arm = b.R * g.point_body;
  return -g.stiffness * (hand.position - b.p - arm) -
         g.damping * (hand.velocity - b.v - b.angular_velocity(what.inertia).cross(arm));
}

HeldBody World::body(int index) const {
  HeldBody out = state_->objects.bodies.at(index);
  out.position = state_->bodies[index].p;
  out.rotation = state_->bodies[index].R;
  return out;
}

Eigen::Vector3d World::body_velocity(int index) const {
  return state_->bodies.at(index).v;
}

Eigen::Vector3d World::body_spin(int index) const {
  const State& s = *state_;
  return s.bodies.at(index)
      .angular_velocity(s.objects.bodies[index].inertia);
}

double World::object_energy() const {
  const State& s = *state_;
  double sum = 0.0;
  for (size_t k = 0; k < s.members.size(); ++k)
    sum += elastic_energy(s.objects.members[k], s.members[k].length);
  for (const Wall& w : s.objects.walls) {
    const double depth = -w.normal.dot(s.point(w.touches).position - w.point);
    if (depth > 0.0) sum += (0.5 * w.stiffness + w.stiffening * depth / 3.0) * depth * depth;
  }
  for (size_t k = 0; k < s.bodies.size(); ++k) {
    const HeldBody& what = s.objects.bodies[k];
    const State::BodyMotion& b = s.bodies[k];
    sum += 0.5 * what.mass * b.v.squaredNorm() + 0.5 * b.angular_velocity(what.inertia).dot(b.spin_momentum);
    for (const HeldBody::Grasp& g : what.grasps) {
      if (!g.attached) continue;
      const Eigen::Vector3d gap = s.point(g.held_by).position - b.p - b.R * g.point_body;
      sum += 0.5 * g.stiffness * gap.squaredNorm();
    }
  }
  return sum;
}

}  // namespace veridyn
