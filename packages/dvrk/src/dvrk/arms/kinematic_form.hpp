#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <vector>

#include "dvrk/arms/arm_facts.hpp"
#include "dvrk/arms/arm_kinematics.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {

/// One DH row that a closed form requires; free numbers are read from the model.
struct ExpectedRow {
  std::optional<double> a, alpha, d, theta;
  bool prismatic = false;
};

/// Throws InvalidInput unless the arm's rows are modified DH rows of this form.
inline void require_form(const ArmFacts& arm, const std::vector<ExpectedRow>& rows) {
  require(arm.kinematic_joints() == static_cast<int>(rows.size()), arm.name, ": found ",
          arm.kinematic_joints(), " joints with DH rows, expected ", rows.size(),
          " for its closed form.");
  std::size_t k = 0;
  for (const ArmJoint& joint : arm.joints) {
    if (!joint.dh) continue;
    const DhRow& found = *joint.dh;
    const ExpectedRow& row = rows[k++];
    const auto fits = [](const std::optional<double>& expected, double value) {
      return !expected || std::abs(*expected - value) < 1e-12;
    };
    require(found.convention == DhConvention::kModified && joint.prismatic == row.prismatic &&
                fits(row.a, found.a) && fits(row.alpha, found.alpha) && fits(row.d, found.d) &&
                fits(row.theta, found.theta),
            arm.name, ": joint ", joint.name, ": found the DH row [", found.a, ", ", found.alpha,
            ", ", found.d, ", ", found.theta, "], expected the form of a ", arm.kind, ".");
  }
}

/// R03 of the remote-centre arms: third column along the shaft.
inline Eigen::Matrix3d shaft_orientation(double yaw, double pitch) {
  const double s1 = std::sin(yaw), c1 = std::cos(yaw), s2 = std::sin(pitch), c2 = std::cos(pitch);
  Eigen::Matrix3d R;
  // clang-format off
  R << -s1 * s2, -c1, s1 * c2,
            -c2, 0.0,     -s2,
        c1 * s2, -s1, -c1 * c2;
  // clang-format on
  return R;
}

/// The best of several solutions: within the limits first, then nearest to `near`. Joints that are not finite
/// are no solution.
template <int n>
class SolutionChoice {
 public:
  using Joints = Eigen::Matrix<double, n, 1>;

  SolutionChoice(const JointRanges<n>& ranges, const Joints& near) : ranges_(ranges), near_(near) {
    best_.q = near;
  }

  void add_candidate(Joints q, bool singular) noexcept {
    if (!q.allFinite()) return;
    ranges_.wrap(q, near_);
    const bool inside = ranges_.contain(q);
    const double distance = (q - near_).squaredNorm();
    if (found_ && (inside_ != inside ? inside_ : distance_ <= distance)) return;
    found_ = true;
    inside_ = inside;
    distance_ = distance;
    best_.q = q;
    best_.status = !inside    ? InverseStatus::kOutsideLimits
                   : singular ? InverseStatus::kSingular
                              : InverseStatus::kDone;
  }

  const InverseSolution<n>& best() const noexcept { return best_; }

 private:
  const JointRanges<n>& ranges_;
  const Joints& near_;
  InverseSolution<n> best_;
  bool found_ = false;
  bool inside_ = false;
  double distance_ = 0.0;
};

}  // namespace veridyn::dvrk
