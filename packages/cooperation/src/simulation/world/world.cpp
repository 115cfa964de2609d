#include "veridyn/simulation/world.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/math/eigen_pose.hpp"
#include "veridyn/math/require.hpp"
#include "simulation/world/world_state.hpp"

namespace veridyn {
namespace {

constexpr double kSubstepAngle = 1.0 / 12.0;  // [rad] largest phase of the fastest oscillation per substep
constexpr double kSubstepDecay = 0.2;         // largest product of decay rate and substep
constexpr double kAhead = 0.01;               // [m] allowance for the depth of a tip in a wall between these updates
constexpr int kReview = 20;                   // steps between updates of the stiffness estimate

void require_positive(double value, const char* what, const std::string& name) {
  require(std::isfinite(value) && value > 0.0, "world: found ", what, " of ", value, " at '", name,
          "', expected a number above zero.");
}

void require_damping(double value, const std::string& name) {
  require(std::isfinite(value) && value >= 0.0, "world: found a damping of ", value, " at '", name,
          "', expected a number that is not below zero.");
}

}  // namespace

World::State::Arm::Arm(WorldArm&& given)
    : model(std::move(given.model)),
      engine(std::move(given.engine)),
      points(model, from_eigen(given.T_world_base)),
      rigid(model, model.inertial_values().value()),
      rotors(MatrixXd::Zero(model.joints(), model.joints())),
      M(rotors),
      J(MatrixXd::Zero(3, model.joints())),
      column(VectorXd::Zero(model.joints())),
      q(column),
      dq(column),
      ddq(column),
      external(column),
      all(column) {
  for (const EffectTerm& term : model.effects()) {
    const EffectFacts effect(model, term);
    if (effect.traits().role != EffectRole::kInertia || !effect.has_values()) continue;
    rotors += effect.inertia() * term.axis.coefficients * term.axis.coefficients.transpose();
  }
}

World::State::State(std::vector<WorldArm> given, WorldObjects things) : objects(std::move(things)) {
  require(!given.empty(), "world: found no arms, expected at least one.");
  const Eigen::Vector3d& g = given.front().model.gravity();
  const Vec3d g_world = rotate(from_eigen(given.front().T_world_base).R, Vec3d{g.x(), g.y(), g.z()});
  gravity = {g_world.x, g_world.y, g_world.z};
  arms.reserve(given.size());
  for (WorldArm& arm : given) {
    require(arm.engine != nullptr && arm.engine->joints() == arm.model.joints(),
            "world: found an arm '", arm.model.name(), "' without an engine of its own.");
    require(arm.model.inertial_values().has_value(), "world: the arm '", arm.model.name(),
            "' has bodies without values.");
    arms.emplace_back(std::move(arm));
  }
  check();
  members.resize(objects.members.size());
  for (const HeldBody& body : objects.bodies) {
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    bodies.push_back({body.position, zero, zero, body.rotation, zero, zero});
  }
  start = rates = bodies;
  update_forces();
}

void World::State::check(const Attachment& at, const char* what) const {
  require(!at.arm || (*at.arm >= 0 && *at.arm < static_cast<int>(arms.size())), "world: found ", what,
          " at arm ", at.arm.value_or(0), ", expected one of ", arms.size(), " from 0, or none for the world.");
  require(at.offset.allFinite(), "world: found ", what, " at a point that is not finite.");
  if (!at.arm) return;
  const Model& model = arms[*at.arm].model;
  require(at.frame.value >= 0 && at.frame.value < static_cast<int>(model.frames().size()), "world: found ",
          what, " at frame ", at.frame.value, ", expected one of the ", model.frames().size(),
          " frames of '", model.name(), "'.");
}

void World::State::check() const {
  for (const Member& m : objects.members) {
    check(m.from, "a member");
    check(m.to, "a member");
    require_positive(m.stiffness, "a stiffness", m.name);
    require_positive(m.rest_length, "a rest length", m.name);
    require_damping(m.damping, m.name);
  }
  for (const Wall& w : objects.walls) {
    check(w.touches, "a wall");
    require_positive(w.stiffness, "a stiffness", "wall");
    require(w.stiffening >= 0.0, "world: found a wall that softens with depth by ", -w.stiffening,
            " N/m^2, expected none.");
    require_damping(w.damping, "wall");
    require_damping(w.drag, "wall");
    require(std::abs(w.normal.norm() - 1.0) < 1e-9,
            "world: found a wall whose normal is not of length one.");
  }
  for (const HeldBody& b : objects.bodies) {
    require_positive(b.mass, "a mass", "body");
    require_positive(b.inertia.minCoeff(), "an inertia", "body");
    for (const HeldBody::Grasp& g : b.grasps) {
      check(g.held_by, "a grasp");
      require_positive(g.stiffness, "a stiffness", "grasp");
      require_damping(g.damping, "grasp");
    }
  }
}

// The trace is an upper bound of the largest eigenvalue. Zero if M is not positive definite.
double World::State::Arm::mobility(const Attachment& at) {
  points.jacobian(at.frame.value, at.offset, J);
  const auto n = static_cast<Eigen::Index>(model.joints());
  double sum = 0.0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {  // |L^-1 J_axis|^2, by Cholesky in place of M
    for (Eigen::Index i = 0; i < n; ++i) {
      double rest = J(axis, i);
      for (Eigen::Index k = 0; k < i; ++k) rest -= M(i, k) * column[k];
      column[i] = M(i, i) > 0.0 ? rest / M(i, i) : 0.0;
      sum += column[i] * column[i];
    }
  }
  return sum;
}

namespace {

void factor_in_place(MatrixXd& M) {  // Cholesky, into the lower triangle; zeros where M is not positive
  for (Eigen::Index j = 0; j < M.rows(); ++j) {
    for (Eigen::Index i = j; i < M.rows(); ++i) {
      double rest = M(i, j);
      for (Eigen::Index k = 0; k < j; ++k) rest -= M(i, k) * M(j, k);
      M(i, j) = i == j ? std::sqrt(std::max(0.0, rest)) : M(j, j) > 0.0 ? rest / M(j, j) : 0.0;
    }
  }
}

}  // namespace

// Number of substeps from an upper bound of the fastest oscillation and decay, summed over all
// objects.
int World::State::choose_substeps(double dt) {
  if (until_review-- <= 0) {
    until_review = kReview;
    for (Arm& arm : arms) {
      arm.rigid.mass_matrix(arm.engine->q(), arm.M);
      arm.M += arm.rotors;
      factor_in_place(arm.M);
    }
    double square = 0.0;
    damping_rate = 0.0;
    const auto add = [&](double stiffness, double damping, double mobility) {
      square += stiffness * mobility;
      damping_rate += damping * mobility;
    };
    const auto of = [&](const Attachment& at) {
      return at.arm ? arms[*at.arm].mobility(at) : 0.0;
    };
    for (const Member& m : objects.members) add(m.stiffness, m.damping, of(m.from) + of(m.to));
    for (const Wall& w : objects.walls) {
      const double depth = kAhead - w.normal.dot(point(w.touches).position - w.point);
      add(w.stiffness + 2.0 * w.stiffening * std::max(0.0, depth), w.damping + w.drag,
          of(w.touches));
    }
    for (const HeldBody& b : objects.bodies) {
      for (const HeldBody::Grasp& g : b.grasps) {
        const double free = 1.0 / b.mass + g.point_body.squaredNorm() / b.inertia.minCoeff();
        add(g.stiffness, g.damping, of(g.held_by) + free);
      }
    }
    fastest = std::sqrt(square);
  }
  const double wanted = std::max(dt * fastest / kSubstepAngle, dt * damping_rate / kSubstepDecay);
  return std::isfinite(wanted) ? std::max(1, static_cast<int>(std::ceil(wanted))) : 1;
}

void World::State::predict(double h) {
  for (Arm& arm : arms) {
    arm.q = arm.engine->q() + h * arm.engine->dq() + 0.5 * h * h * arm.ddq;
    arm.dq = arm.engine->dq() + h * arm.ddq;
    arm.points.move_to(arm.q, arm.dq);
  }
  predict_bodies(h);
}

// Updates points, members and forces at the present state; clears the sums of a substep.
void World::State::update_forces() {
  for (Arm& arm : arms) arm.ddq.setZero();
  start = bodies;
  predict(0.0);
  clear_forces();
  add_forces(1.0, 0.0);
}

StepStatus World::State::substep(const std::vector<VectorXd>& tau, double h) {
  // At this point the forces are those of the last update_forces().
  for (size_t k = 0; k < arms.size(); ++k) {
    Arm& arm = arms[k];
    arm.all = tau[k] + arm.external;
    const StepStatus status = arm.engine->accelerate(arm.all, arm.ddq);
    if (status != StepStatus::kOk) return status;
  }
  start = bodies;
  rates = bodies;
  predict(0.0);
  clear_forces();
  add_forces(1.0 / 6.0, h);
  predict(0.5 * h);
  add_forces(4.0 / 6.0, h);
  predict(h);
  add_forces(1.0 / 6.0, h);
  for (size_t k = 0; k < arms.size(); ++k) {
    Arm& arm = arms[k];
    arm.all = tau[k] + arm.external;
    const StepStatus status = arm.engine->step(arm.all, h);
    if (status != StepStatus::kOk) return status;
  }
  move_bodies(h);
  update_forces();
  time += h;
  return StepStatus::kOk;
}

World::World(std::vector<WorldArm> arms, WorldObjects objects)
    : state_(std::make_unique<State>(std::move(arms), std::move(objects))) {}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

int World::arms() const {
  return static_cast<int>(state_->arms.size());
}
double World::time() const {
  return state_->time;
}
int World::substeps() const {
  return state_->count;
}
const Engine& World::engine(int arm) const {
  return *state_->arms.at(arm).engine;
}
const VectorXd& World::q(int arm) const {
  return engine(arm).q();
}
const VectorXd& World::dq(int arm) const {
  return engine(arm).dq();
}
const World::MemberState& World::member(int index) const {
  return state_->members.at(index);
}
World::PointMotion World::point(const Attachment& at) {
  state_->check(at, "a point");
  return state_->point(at);
}
double World::work_on_objects() const {
  return state_->work;
}

void World::set_state(int arm, const VectorRef& q, const VectorRef& dq) {
  State& s = *state_;
  s.arms.at(arm).engine->set_state(q, dq);
  s.time = s.work = 0.0;
  s.until_review = 0;
  s.update_forces();
}

void World::hit(int arm, const VectorRef& q, const VectorRef& dq) {
  State& s = *state_;
  s.arms.at(arm).engine->set_state(q, dq);
  s.until_review = 0;
  s.update_forces();
}

void World::detach(int member) {
  state_->objects.members.at(member).attached = false;
  state_->update_forces();
}

void World::attach(int member, double rest_length) {
  require_positive(rest_length, "a rest length", "member");
  Member& m = state_->objects.members.at(member);
  m.attached = true;
  m.rest_length = rest_length;
  state_->update_forces();
}

StepStatus World::step(const std::vector<VectorXd>& tau, double dt) noexcept {
  State& s = *state_;
  s.count = s.choose_substeps(dt);
  for (int k = 0; k < s.count; ++k) {
    const StepStatus status = s.substep(tau, dt / s.count);
    if (status != StepStatus::kOk) return status;
  }
  return StepStatus::kOk;
}

}  // namespace veridyn
