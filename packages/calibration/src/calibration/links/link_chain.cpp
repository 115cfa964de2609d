#include "calibration/links/link_chain.hpp"

#include <cmath>

#include "veridyn/math/eigen_pose.hpp"
#include "veridyn/model/joint_placement.hpp"

namespace veridyn::internal {
namespace {

using Kind = LinkParameter::Kind;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

Isometry3d rotation_about_z(double angle) {
  return Isometry3d(Eigen::AngleAxisd(angle, Vector3d::UnitZ()));
}

Isometry3d rotation_about_x(double angle) {
  return Isometry3d(Eigen::AngleAxisd(angle, Vector3d::UnitX()));
}

Isometry3d translation_by(double x, double y, double z) {
  return Isometry3d(Eigen::Translation3d(x, y, z));
}

// A small rotation about a line, or a small translation along it.
struct Motion {
  bool turns = true;
  Vector3d axis{0, 0, 1};
  Vector3d point{0, 0, 0};
};

using Column = Eigen::Matrix<double, 6, 1>;

// Rotation and translation, in that order, of a body with its origin at p per unit of a motion.
Column pose_derivative(const Motion& m, const Vector3d& p) {
  Column out;
  if (m.turns) {
    out << m.axis, m.axis.cross(p - m.point);
  } else {
    out << Vector3d::Zero(), m.axis;
  }
  return out;
}

}  // namespace

LinkChain::LinkChain(const LinkParameters& parameters, const Isometry3d& base,
                     const Isometry3d& tool)
    : parameters_(parameters),
      sensors_(parameters.arm()),
      base_start_(base),
      tool_start_(tool),
      base_(base),
      tool_(tool) {
  const Model& arm = parameters.arm();
  entry_parameter_.assign(parameters.entries().size(), -1);
  zero_parameter_.assign(static_cast<std::size_t>(arm.joints()), -1);
  for (int p = 0; p < parameters.size(); ++p) {
    const LinkParameter& one = parameters.all()[p];
    if (one.kind == Kind::kEntry) entry_parameter_[one.index] = p;
    if (one.kind == Kind::kZero) zero_parameter_[one.index] = p;
    if (one.kind == Kind::kConstant) constants_.push_back(p);
  }
  for (const int k : parameters.path()) {
    const Frame& frame = arm.frames()[k];
    rest_.push_back(frame.dh ? Isometry3d::Identity()
                             : eigen(inverse(joint_placement(frame).origin) * frame.A));
  }
  set(VectorXd::Zero(parameters.size()));
}

void LinkChain::set(const VectorRef& x) {
  x_ = x;
  parameters_.evaluate(x_, values_, &by_constant_);
  Eigen::Matrix<double, 6, 1> base = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Matrix<double, 6, 1> tool = base;
  for (int p = 0; p < parameters_.size(); ++p) {
    const LinkParameter& one = parameters_.all()[p];
    if (one.kind == Kind::kBase) base[one.index] = x_[p];
    if (one.kind == Kind::kTool) tool[one.index] = x_[p];
  }
  base_ = base_start_;
  base_.linear() = rotation_of(base.head<3>()) * base_start_.linear();
  base_.translation() += base.tail<3>();
  tool_ = tool_start_;
  tool_.linear() = tool_start_.linear() * rotation_of(tool.head<3>());
  tool_.translation() += tool.tail<3>();
}

Isometry3d LinkChain::pose(const VectorRef& recorded, MatrixXd* J) const {
  const Model& arm = parameters_.arm();
  VectorXd q = recorded;
  sensors_.correct_positions(q);
  // Further correction by the parameters of the fit.
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const int zero = zero_parameter_[i];
    if (zero >= 0) q[i] -= x_[zero];
  }
  std::vector<Motion> motions(J == nullptr ? 0 : parameters_.entries().size());
  Isometry3d T = base_;
  std::size_t entry = 0;
  const auto note = [&](std::size_t k, bool turns, const Vector3d& axis, const Vector3d& point) {
    if (J != nullptr) motions[k] = {turns, axis, point};
  };
  for (std::size_t f = 0; f < parameters_.path().size(); ++f) {
    const Frame& frame = arm.frames()[parameters_.path()[f]];
    const auto v = [&](std::size_t k) { return values_[static_cast<Eigen::Index>(entry + k)]; };
    const std::size_t own = frame.dh ? 4 : 6;
    const bool turns = frame.type == JointType::kRevolute;
    const bool slides = frame.type == JointType::kPrismatic;
    // The offset of the joint variable, without the constant of its row.
    double s = frame.dh ? 0.0 : frame.variable.offset;
    std::size_t ratios = 0;
    while (entry + own + ratios < parameters_.entries().size() &&
           parameters_.entries()[entry + own + ratios].constant.joint &&
           parameters_.entries()[entry + own + ratios].constant.frame.value == parameters_.path()[f]) {
      s += v(own + ratios) * q[parameters_.entries()[entry + own + ratios].constant.joint->value];
      ++ratios;
    }
    Motion joint;
    joint.turns = turns;
    if (frame.dh) {
      const Isometry3d link = rotation_about_x(v(1)) * translation_by(v(0), 0, 0);
      const bool modified = frame.dh->convention == DhConvention::kModified;
      if (modified) {
        note(entry, false, T.linear().col(0), T.translation());
        note(entry + 1, true, T.linear().col(0), T.translation());
        T = T * link;
      }
      const Vector3d z = T.linear().col(2);
      note(entry + 2, false, z, T.translation());
      note(entry + 3, true, z, T.translation());
      joint.axis = z;
      joint.point = T.translation();
      T = T * rotation_about_z(v(3) + (turns ? s : 0.0)) * translation_by(0, 0, v(2) + (slides ? s : 0.0));
      if (!modified) {
        note(entry, false, T.linear().col(0), T.translation());
        note(entry + 1, true, T.linear().col(0), T.translation());
        T = T * link;
      }
    } else {
      const Isometry3d parent = T;
      const Vector3d at = parent * Vector3d(v(0), v(1), v(2));
      const Matrix3d yaw = parent.linear() * rotation_about_z(v(5)).linear();
      const Matrix3d pitch =
          yaw * Eigen::AngleAxisd(v(4), Vector3d::UnitY()).toRotationMatrix();
      for (int c = 0; c < 3; ++c)
        note(entry + static_cast<std::size_t>(c), false, parent.linear().col(c), at);
      note(entry + 3, true, pitch.col(0), at);
      note(entry + 4, true, yaw.col(1), at);
      note(entry + 5, true, parent.linear().col(2), at);
      T.linear() = pitch * rotation_about_x(v(3)).linear();
      T.translation() = at;
      T = T * rest_[f];
      joint.axis = T.linear().col(2);
      joint.point = T.translation();
      if (turns) T = T * rotation_about_z(s);
      if (slides) T = T * translation_by(0, 0, s);
      T = T * eigen(frame.B);
    }
    for (std::size_t r = 0; r < ratios; ++r)
      note(entry + own + r, joint.turns, joint.axis, joint.point);
    entry += own + ratios;
  }
  const Isometry3d body = T * tool_;
  if (J == nullptr) return body;
  J->setZero(6, parameters_.size());
  const Vector3d p = body.translation();
  for (std::size_t k = 0; k < motions.size(); ++k) {
    const std::optional<JointIndex> joint = parameters_.entries()[k].constant.joint;
    const Column column = pose_derivative(motions[k], p);
    double by_entry = 1.0;
    if (joint) {
      const int zero = zero_parameter_[joint->value];
      by_entry = q[joint->value];
      if (zero >= 0) J->col(zero) -= values_[static_cast<Eigen::Index>(k)] * column;
    }
    if (entry_parameter_[k] >= 0) J->col(entry_parameter_[k]) += by_entry * column;
    for (const int c : constants_) {
      const double slope = by_constant_(static_cast<Eigen::Index>(k), c);
      if (slope != 0.0) J->col(c) += slope * by_entry * column;
    }
  }
  for (int k = 0; k < parameters_.size(); ++k) {
    const LinkParameter& one = parameters_.all()[k];
    if (one.kind != Kind::kBase && one.kind != Kind::kTool) continue;
    const bool is_base = one.kind == Kind::kBase;
    Eigen::Matrix<double, 3, 1> unit = Vector3d::Zero();
    unit[one.index % 3] = 1.0;
    if (is_base && one.index < 3) {
      Vector3d w = Vector3d::Zero();
      for (int c = 0; c < parameters_.size(); ++c) {
        const LinkParameter& other = parameters_.all()[c];
        if (other.kind == Kind::kBase && other.index < 3) w[other.index] = x_[c];
      }
      J->col(k) = pose_derivative({true, right_jacobian(-w) * unit, base_.translation()}, p);
    } else if (is_base) {
      J->col(k) = pose_derivative({false, unit, p}, p);
    } else if (one.index < 3) {
      Vector3d w = Vector3d::Zero();
      for (int c = 0; c < parameters_.size(); ++c) {
        const LinkParameter& other = parameters_.all()[c];
        if (other.kind == Kind::kTool && other.index < 3) w[other.index] = x_[c];
      }
      J->col(k) << body.linear() * right_jacobian(w) * unit, Vector3d::Zero();
    } else {
      J->col(k) << Vector3d::Zero(), T.linear() * unit;
    }
  }
  return body;
}

}  // namespace veridyn::internal
