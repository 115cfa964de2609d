#include "excitation/limits/limit_signals.hpp"

#include <algorithm>
#include <cmath>

#include "math/numbers.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"
#include "veridyn/effects/effect_facts.hpp"

namespace veridyn {
namespace {

constexpr double kMarginOfSupervisor = 0.0025;  // share of a range that MotionCheck leaves at each end
constexpr double kSizeOfGap = 0.1;      // [m] scale of gaps, and of boxes
constexpr double kRoundedShare = 0.01;  // share of the largest speed within which signs in torques are smoothed

}  // namespace

LimitSignals::LimitSignals(const Model& arm, const MotionLimits& joints,
                           const WorkspaceLimits& workspace, const std::optional<Model>& powered,
                           double braking)
    : joints_(arm.joints()), arm_(arm), braking_(braking) {
  const auto each = [&](LimitKind kind, const char* what, const char* per, const VectorXd& lower,
                        const VectorXd& upper, const VectorXd& scale) {
    for (int i = 0; i < joints_; ++i) {
      const Coordinate& c = arm.coordinates()[i];
      signals_.push_back(
          {text(what, " of ", c.name), position_unit(c) + per, lower[i], upper[i], scale[i], kind, JointIndex{i}});
    }
  };
  each(LimitKind::kPosition, "position", "", joints.lower, joints.upper, joints.upper - joints.lower);
  each(LimitKind::kSpeed, "speed", "/s", -joints.velocity, joints.velocity, joints.velocity);
  each(LimitKind::kAcceleration, "acceleration", "/s^2", -joints.acceleration, joints.acceleration, joints.acceleration);
  if (braking_ > 0.0) add_stops(joints);
  if (powered) add_torques(*powered);
  add_workspace(arm, workspace);
}

void LimitSignals::add_stops(const MotionLimits& joints) {
  for (int i = 0; i < joints_; ++i) {
    const Coordinate& c = arm_.coordinates()[i];
    const double margin = kMarginOfSupervisor * (joints.upper[i] - joints.lower[i]);
    signals_.push_back({text("stop of ", c.name), position_unit(c), joints.lower[i] + margin,
                        joints.upper[i] - margin, joints.upper[i] - joints.lower[i], LimitKind::kStop, JointIndex{i}});
  }
}

void LimitSignals::add_torques(const Model& powered) {
  const auto phi = powered.inertial_values();
  require(phi.has_value() && powered.joints() == joints_,
          "excitation: torques are limited, but the arm '", powered.name(),
          "' has no inertial values or other joints.");
  for (int i = 0; i < joints_; ++i) {
    const Coordinate& c = powered.coordinates()[i];
    const double most = c.limits.effort;
    if (!std::isfinite(most)) continue;
    torque_joints_.push_back(i);
    signals_.push_back({text("torque of ", c.name), effort_unit(c), -most, most, most, LimitKind::kTorque, JointIndex{i}});
  }
  if (torque_joints_.empty()) return;
  phi_ = *phi;
  bodies_ = std::make_unique<TorqueRegressor>(powered);
  const VectorXd rounding = kRoundedShare * motion_limits(powered).velocity;
  for (const EffectTerm& term : powered.effects()) {
    const EffectFacts bound(powered, term);
    if (!bound.has_values()) continue;
    effects_.push_back(effect_columns(powered, term, rounding));
    effect_values_.push_back(
        Eigen::Map<const VectorXd>(bound.values().data(), bound.parameter_count()));
  }
}

std::optional<FrameIndex> LimitSignals::frame_index(const Model& arm, const std::string& name) const {
  if (name == "world") return std::nullopt;
  std::vector<std::string> names;
  for (const Frame& frame : arm.frames()) names.push_back(frame.name);
  const std::optional<FrameIndex> k = arm.find_frame(name);
  require(k.has_value(), "excitation: found the frame '", name, "'", did_you_mean(name, names),
          ", expected world or one of: ", listed(names), ".");
  return k;
}

void LimitSignals::add_workspace(const Model& arm, const WorkspaceLimits& workspace) {
  using Kind = Geometry::Kind;
  const Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  for (const FrameBox& box : workspace.boxes) {
    const std::optional<FrameIndex> frame = frame_index(arm, box.frame);
    for (int axis = 0; axis < 3; ++axis) {
      const double low = box.lower[axis];
      const double high = box.upper[axis];
      require(low < high, "excitation: the box of '", box.frame, "' goes from ", low, " m to ",
              high, " m, expected the smaller bound first.");
      if (!std::isfinite(low) && !std::isfinite(high)) continue;
      const double size = std::isfinite(high - low) ? high - low : 0.1;
      geometries_.push_back({Kind::kCoordinate, axis, frame, std::nullopt, origin, origin});
      signals_.push_back({text("xyz"[axis], " of ", box.frame), "m", low, high, size});
    }
  }
  for (const SpherePair& pair : workspace.pairs) {
    const double least = pair.first.radius + pair.second.radius + pair.clearance;
    require(least > 0.0, "excitation: the spheres on '", pair.first.frame, "' and '",
            pair.second.frame, "' have no size.");
    geometries_.push_back({Kind::kDistance, 0, frame_index(arm, pair.first.frame),
                           frame_index(arm, pair.second.frame), pair.first.centre,
                           pair.second.centre});
    signals_.push_back({text("distance of ", pair.first.frame, " and ", pair.second.frame), "m",
                        least, kInfinity, least});
  }
  for (const InsertionRange& range : workspace.insertions) {
    require(range.lower < range.upper, "excitation: the insertion of '", range.frame,
            "' goes from ", range.lower, " m to ", range.upper,
            " m, expected the smaller bound first.");
    const std::optional<FrameIndex> frame = frame_index(arm, range.frame);
    require(frame.has_value(), "excitation: the world cannot be inserted anywhere.");
    geometries_.push_back({Kind::kInsertion, 0, frame, std::nullopt, origin, range.centre});
    signals_.push_back({text("insertion of ", range.frame), "m", range.lower, range.upper,
                        range.upper - range.lower});
  }
  for (const CollisionPair& pair : workspace.collisions.pairs) {
    gaps_.emplace_back(arm, pair);
    signals_.push_back({text("gap of ", pair.first, " and ", pair.second), "m", pair.clearance, kInfinity, kSizeOfGap});
  }
}

double LimitSignals::workspace_signal(const FramePoints& at, size_t k, Eigen::RowVectorXd* slope) const {
  const Geometry& g = geometries_[k];
  const Eigen::Vector3d p = at.point(g.frame, g.point);
  if (g.kind == Geometry::Kind::kCoordinate) {
    if (slope != nullptr) *slope = at.point_slope(g.frame, g.point).row(g.axis);
    return p[g.axis];
  }
  const Eigen::Vector3d way = p - at.point(g.other, g.other_point);
  if (g.kind == Geometry::Kind::kDistance) {
    const double distance = std::max(way.norm(), 1e-9);
    if (slope != nullptr) {
      *slope = (way / distance).transpose() *
               (at.point_slope(g.frame, g.point) - at.point_slope(g.other, g.other_point));
    }
    return distance;
  }
  const Eigen::Vector3d z = at.z_axis(g.frame);
  if (slope != nullptr) {
    *slope = z.transpose() * at.point_slope(g.frame, g.point) +
             way.transpose() * at.z_axis_slope(g.frame);
  }
  return way.dot(z);
}

double LimitSignals::gap(const FramePoints& at, size_t k, Eigen::RowVectorXd* slope) const {
  const LinkGap::Nearest nearest = gaps_[k].nearest(at);
  if (slope != nullptr) {
    *slope = nearest.direction.transpose() * at.point_slope(nearest.frame, nearest.point);
    if (nearest.other)
      *slope -= nearest.direction.transpose() * at.point_slope(nearest.other, nearest.other_point);
  }
  return nearest.gap;
}

MatrixXd LimitSignals::torques(const MotionSamples& motion) const {
  MatrixXd tau;
  bodies_->torques(motion.q, motion.dq, motion.ddq, phi_, tau);
  std::vector<MatrixXd> Y;
  for (size_t e = 0; e < effects_.size(); ++e) {
    effects_[e]->evaluate(motion, Y);
    for (Eigen::Index i = 0; i < tau.cols(); ++i) {
      if (Y[i].cols() > 0)
        tau.col(i) += Y[i] * effect_values_[e];
    }
  }
  return tau;
}

void LimitSignals::torque_derivatives(const MotionSamples& motion, std::vector<MatrixXd>& slopes) const {
  const Eigen::Index n = motion.joints();
  MatrixXd rigid;
  bodies_->torque_derivatives(motion.q, motion.dq, motion.ddq, phi_, rigid);
  for (const int i : torque_joints_) {
    MatrixXd own(motion.rows(), 3 * n);
    for (Eigen::Index d = 0; d < 3 * n; ++d) own.col(d) = rigid.col(d * n + i);
    for (size_t e = 0; e < effects_.size(); ++e) {
      if (effects_[e]->has_memory() || effects_[e]->columns(i).empty()) continue;
      std::vector<MatrixXd> weights;
      for (int j = 0; j < joints_; ++j) {
        const auto columns = static_cast<Eigen::Index>(effects_[e]->columns(j).size());
        weights.push_back(MatrixXd::Zero(motion.rows(), columns));
        if (j == i) weights.back().rowwise() = effect_values_[e].transpose();
      }
      effects_[e]->add_gradient(motion, weights, own);
    }
    slopes.push_back(std::move(own));
  }
}

MatrixXd LimitSignals::values(const MotionSamples& motion) const {
  MatrixXd out(motion.rows(), count() - 3 * joints_);
  Eigen::Index next = 0;
  for (int i = 0; i < joints_ && braking_ > 0.0; ++i)
    out.col(next++) = motion.q.col(i) + motion.dq.col(i) / braking_;
  if (!torque_joints_.empty()) {
    const MatrixXd tau = torques(motion);
    for (const int i : torque_joints_) out.col(next++) = tau.col(i);
  }
  if (geometric_count() == 0) return out;
  FramePoints at(arm_);
  for (Eigen::Index row = 0; row < motion.rows(); ++row) {
    at.move_to(motion.q.row(row));
    for (size_t k = 0; k < geometric_count(); ++k) {
      out(row, next + static_cast<Eigen::Index>(k)) = geometric(at, k, nullptr);
    }
  }
  return out;
}

std::vector<MatrixXd> LimitSignals::derivatives(const MotionSamples& motion) const {
  std::vector<MatrixXd> out;
  for (int i = 0; i < joints_ && braking_ > 0.0; ++i) {
    out.push_back(MatrixXd::Zero(motion.rows(), 3 * motion.joints()));
    out.back().col(i).setOnes();
    out.back().col(joints_ + i).setConstant(1.0 / braking_);
  }
  if (!torque_joints_.empty()) torque_derivatives(motion, out);
  const size_t first = out.size();
  for (size_t k = 0; k < geometric_count(); ++k) {
    out.push_back(MatrixXd::Zero(motion.rows(), 3 * motion.joints()));
  }
  if (geometric_count() == 0) return out;
  FramePoints at(arm_);
  Eigen::RowVectorXd slope;
  for (Eigen::Index row = 0; row < motion.rows(); ++row) {
    at.move_to(motion.q.row(row));
    for (size_t k = 0; k < geometric_count(); ++k) {
      geometric(at, k, &slope);
      out[first + k].row(row).head(motion.joints()) = slope;
    }
  }
  return out;
}

}  // namespace veridyn
