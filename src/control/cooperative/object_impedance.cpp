#include "veridyn/control/object_impedance.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kSingular = 1e-6;  // damping relative to the square of the grasps' mean distance
constexpr int kSteps = 3;           // Gauss-Newton steps per cycle

Matrix3d cross_matrix(const Vector3d& a) {
  Matrix3d m;
  // clang-format off
  m <<      0, -a.z(),  a.y(),
        a.z(),      0, -a.x(),
       -a.y(),  a.x(),      0;
  // clang-format on
  return m;
}

// The rotation of a rotation vector [rad]; the identity if it is zero or not finite.
Matrix3d turned(const Vector3d& by) {
  const double angle = by.norm();
  return angle > 0.0 && std::isfinite(angle) ? Eigen::AngleAxisd(angle, by / angle).toRotationMatrix()
                                             : Matrix3d::Identity();
}

// The rotation vector from R to R_wanted, in the world.
Vector3d turn_between(const Matrix3d& R, const Matrix3d& R_wanted) {
  const Eigen::AngleAxisd turn(Matrix3d(R_wanted * R.transpose()));
  return turn.angle() * turn.axis();
}

}  // namespace

ObjectImpedance::ObjectImpedance(const ObjectImpedanceOptions& options)
    : options_(options),
      reach_(0.0),
      internal_(Eigen::MatrixXd::Zero(options.grasps.size(),
                                      static_cast<Eigen::Index>(options.grasps.size()))),
      targets_(options.grasps.size()) {
  require(!options.grasps.empty(), "object impedance: found no grasps, expected at least one.");
  for (const Vector3d& r : options.grasps) {
    require(r.allFinite(), "object impedance: found a grasp that is not finite.");
    reach_ += r.norm() / static_cast<double>(options.grasps.size());
  }
  if (!(reach_ > 0.0)) reach_ = 1.0;
  for (const double value :
       {options.mass, options.inertia.x(), options.inertia.y(), options.inertia.z(), options.damping,
        options.stiffness, options.angular_damping, options.angular_stiffness}) {
    require(std::isfinite(value) && value >= 0.0, "object impedance: found ", value,
            ", expected numbers that are finite and not below zero.");
  }
  require(options.wanted_mass > 0.0 && options.wanted_inertia > 0.0,
          "object impedance: found a wanted mass of ", options.wanted_mass, " and an inertia of ",
          options.wanted_inertia, ", expected both above zero.");
  require(options.gravity.allFinite(), "object impedance: found a gravity that is not finite.");
}

bool ObjectImpedance::set_internal_force(int hand, int other, double force) noexcept {
  if (hand < 0 || other < 0 || hand >= hands() || other >= hands() || hand == other ||
      !std::isfinite(force))
    return false;
  internal_(hand, other) = internal_(other, hand) = force;
  return true;
}

const ObjectMotion& ObjectImpedance::estimate(const std::vector<Vector3d>& positions,
                                              const std::vector<Vector3d>& velocities) noexcept {
  const auto count = static_cast<double>(positions.size());
  Vector3d centre = Vector3d::Zero();
  Vector3d grasps = Vector3d::Zero();
  Vector3d drift = Vector3d::Zero();
  for (size_t i = 0; i < targets_.size(); ++i) {
    centre += positions[i] / count;
    drift += velocities[i] / count;
    grasps += options_.grasps[i] / count;
  }
  if (!centre.allFinite() || !drift.allFinite()) return now_;
  const double small = kSingular * reach_ * reach_;
  for (int step = 0; step < kSteps; ++step) {
    Matrix3d A = small * Matrix3d::Identity();
    Vector3d b = Vector3d::Zero();
    Vector3d spun = Vector3d::Zero();
    for (size_t i = 0; i < targets_.size(); ++i) {
      const Vector3d r = now_.rotation * (options_.grasps[i] - grasps);
      const Matrix3d X = cross_matrix(r);
      A -= X * X;
      b += r.cross(positions[i] - centre - r);
      spun += r.cross(velocities[i] - drift);
    }
    const Eigen::LDLT<Matrix3d> solver(A);
    now_.spin = solver.solve(spun);
    now_.rotation = turned(solver.solve(b)) * now_.rotation;
  }
  now_.rotation = Eigen::Quaterniond(now_.rotation).normalized().toRotationMatrix();
  const Vector3d lever = now_.rotation * grasps;
  now_.position = centre - lever;
  now_.velocity = drift - now_.spin.cross(lever);
  return now_;
}

// The smallest forces of the hands with resultant force F and moment N: an equal share of F for each, and y x
// (r_i - r), with sum zero, for the rest of N.
void ObjectImpedance::distribute(const ObjectMotion& now, const Vector3d& F,
                                 const Vector3d& N) noexcept {
  const double share = 1.0 / static_cast<double>(hands());
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& grasp : options_.grasps) middle += share * (now.rotation * grasp);
  Matrix3d S = kSingular * reach_ * reach_ * Matrix3d::Identity();
  for (const Vector3d& grasp : options_.grasps) {
    const Matrix3d X = cross_matrix(now.rotation * grasp - middle);
    S -= X * X;
  }
  const Vector3d y = Eigen::LDLT<Matrix3d>(S).solve(Vector3d(N - middle.cross(F)));
  for (size_t i = 0; i < targets_.size(); ++i) {
    const Vector3d lever = now.rotation * options_.grasps[i] - middle;
    targets_[i].force = share * F + y.cross(lever);
  }
}

const std::vector<TipTarget>& ObjectImpedance::update(const ObjectMotion& now,
                                                      const ObjectMotion& wanted,
                                                      const Vector3d& force,
                                                      const Vector3d& moment) noexcept {
  const ObjectImpedanceOptions& o = options_;
  const Vector3d a =
      wanted.acceleration + (o.damping * (wanted.velocity - now.velocity) +
                             o.stiffness * (wanted.position - now.position) + force) /
                                o.wanted_mass;
  const Vector3d alpha =
      wanted.spin_rate +
      (o.angular_damping * (wanted.spin - now.spin) +
       o.angular_stiffness * turn_between(now.rotation, wanted.rotation) + moment) /
          o.wanted_inertia;
  const Matrix3d I = now.rotation * o.inertia.asDiagonal() * now.rotation.transpose();
  distribute(now, o.mass * (a - o.gravity) - force,
             I * alpha + now.spin.cross(Vector3d(I * now.spin)) - moment);
  for (size_t i = 0; i < targets_.size(); ++i) {
    const Vector3d r = wanted.rotation * o.grasps[i];
    TipTarget& target = targets_[i];
    target.motion = target.position = wanted.position + r;
    target.velocity = wanted.velocity + wanted.spin.cross(r);
    target.acceleration =
        wanted.acceleration + wanted.spin_rate.cross(r) + wanted.spin.cross(wanted.spin.cross(r));
    for (size_t j = 0; j < targets_.size(); ++j) {
      const Vector3d line = now.rotation * (o.grasps[i] - o.grasps[j]);
      const double h = internal_(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      if (h != 0.0 && line.norm() > 0.0) target.force += h * line.normalized();
    }
  }
  return targets_;
}

}  // namespace veridyn
