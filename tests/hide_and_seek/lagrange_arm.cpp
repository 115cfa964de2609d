#include "hide_and_seek/lagrange_arm.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "veridyn/math/require.hpp"

namespace veridyn::seek {
namespace {

// Steps of the differences: truncation grows with the fourth power, rounding with 1 / step^2 (1e-16
// / 2.5e-5 = 4e-12) and 1 / step.
constexpr double kTimeStep = 5e-3;  // [s]
constexpr double kJointStep = 2e-3;

Matrix4d turn_z_shift_z(double angle, double shift) {
  Matrix4d T = Matrix4d::Identity();
  T(0, 0) = T(1, 1) = std::cos(angle);
  T(1, 0) = std::sin(angle);
  T(0, 1) = -T(1, 0);
  T(2, 3) = shift;
  return T;
}

Matrix4d turn_x_shift_x(double angle, double shift) {
  Matrix4d T = Matrix4d::Identity();
  T(1, 1) = T(2, 2) = std::cos(angle);
  T(2, 1) = std::sin(angle);
  T(1, 2) = -T(2, 1);
  T(0, 3) = shift;
  return T;
}

// (-f(2h) + 8 f(h) - 8 f(-h) + f(-2h)) / 12 h
Matrix4d slope(const Matrix4d& m2, const Matrix4d& m1, const Matrix4d& p1, const Matrix4d& p2,
               double h) {
  return (8.0 * (p1 - m1) - (p2 - m2)) / (12.0 * h);
}

constexpr int kMoments = 10;
constexpr std::array<std::pair<int, int>, kMoments> kMomentEntries = {
    {{3, 3}, {0, 3}, {1, 3}, {2, 3}, {0, 0}, {0, 1}, {1, 1}, {0, 2}, {1, 2}, {2, 2}}};

}  // namespace

std::vector<Matrix4d> LagrangeArm::poses(const VectorXd& q) const {
  std::vector<Matrix4d> out(links.size());
  for (size_t k = 0; k < links.size(); ++k) {
    const Link& link = links[k];
    const double s = link.ratios.dot(q);
    const Matrix4d along_z =
        turn_z_shift_z(link.theta + (link.slides ? 0.0 : s), link.d + (link.slides ? s : 0.0));
    const Matrix4d along_x = turn_x_shift_x(link.alpha, link.a);
    const Matrix4d T = link.modified ? Matrix4d(along_x * along_z) : Matrix4d(along_z * along_x);
    out[k] = link.parent < 0 ? T : Matrix4d(out[link.parent] * T);
  }
  return out;
}

void LagrangeArm::for_each_force(const VectorXd& q, const VectorXd& dq, const VectorXd& ddq,
                                 const Visit& visit) const {
  const auto later = [&](double t) { return poses(q + t * dq + 0.5 * t * t * ddq); };
  const auto m2 = later(-2.0 * kTimeStep);
  const auto m1 = later(-kTimeStep);
  const auto here = poses(q);
  const auto p1 = later(kTimeStep);
  const auto p2 = later(2.0 * kTimeStep);
  std::vector<Matrix4d> push(links.size());
  for (size_t k = 0; k < links.size(); ++k) {
    push[k] = (16.0 * (p1[k] + m1[k]) - (p2[k] + m2[k]) - 30.0 * here[k]) /
              (12.0 * kTimeStep * kTimeStep);
    push[k].block<3, 1>(0, 3) -= gravity;
  }
  for (int i = 0; i < joints; ++i) {
    const auto moved = [&](double step) {
      VectorXd at = q;
      at[i] += step;
      return poses(at);
    };
    const auto a = moved(-2.0 * kJointStep);
    const auto b = moved(-kJointStep);
    const auto c = moved(kJointStep);
    const auto d = moved(2.0 * kJointStep);
    for (size_t k = 0; k < links.size(); ++k) {
      if (!links[k].has_body) continue;
      const Matrix4d D = slope(a[k], b[k], c[k], d[k], kJointStep);
      visit(i, static_cast<int>(k), D.transpose() * push[k]);
    }
  }
}

VectorXd LagrangeArm::torque(const VectorXd& q, const VectorXd& dq, const VectorXd& ddq) const {
  VectorXd tau = VectorXd::Zero(joints);
  for_each_force(q, dq, ddq, [&](int i, int k, const Matrix4d& W) {
    tau[i] += links[k].moments.cwiseProduct(W).sum();
  });
  return tau;
}

MatrixXd LagrangeArm::regressor(const VectorXd& q, const VectorXd& dq, const VectorXd& ddq) const {
  std::vector<int> first(links.size(), 0);
  int columns = 0;
  for (size_t k = 0; k < links.size(); ++k) {
    first[k] = columns;
    if (links[k].has_body) columns += kMoments;
  }
  MatrixXd Y = MatrixXd::Zero(joints, columns);
  for_each_force(q, dq, ddq, [&](int i, int k, const Matrix4d& W) {
    for (int p = 0; p < kMoments; ++p) {
      const auto [r, c] = kMomentEntries[p];
      Y(i, first[k] + p) = r == c ? W(r, r) : W(r, c) + W(c, r);
    }
  });
  return Y;
}

MatrixXd LagrangeArm::torques(const MatrixXd& q, const MatrixXd& dq, const MatrixXd& ddq) const {
  MatrixXd tau(q.rows(), joints);
  for (Eigen::Index r = 0; r < q.rows(); ++r)
    tau.row(r) = torque(q.row(r).transpose(), dq.row(r).transpose(), ddq.row(r).transpose());
  return tau;
}

LagrangeArm lagrange_arm(const Model& arm) {
  LagrangeArm out;
  out.joints = arm.joints();
  out.gravity = arm.gravity();
  for (const Frame& frame : arm.frames()) {
    require(frame.dh.has_value(), "hide and seek: frame '", frame.name,
            "' has no DH row, expected one.");
    Link link;
    link.name = frame.name;
    if (frame.parent) link.parent = frame.parent->value;
    link.a = frame.dh->a;
    link.alpha = frame.dh->alpha;
    link.d = frame.dh->d;
    link.theta = frame.dh->theta;
    link.modified = frame.dh->convention == DhConvention::kModified;
    link.slides = frame.type == JointType::kPrismatic;
    link.ratios = VectorXd::Zero(out.joints);
    if (frame.type != JointType::kFixed) link.ratios = frame.variable.coefficients;
    link.has_body = frame.body.has_value();
    out.links.push_back(std::move(link));
  }
  return out;
}

Matrix4d point_mass(double mass, const Vector3d& place) {
  const Eigen::Vector4d point(place.x(), place.y(), place.z(), 1.0);
  return mass * point * point.transpose();
}

}  // namespace veridyn::seek
