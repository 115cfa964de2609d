#include <cmath>

#include "dvrk/arms/arm_kinematics.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kTurn = 2.0 * M_PI;
// Tolerance for rounding at a joint's limit.
constexpr double kSlack = 1e-9;

}  // namespace

template <int n>
JointRanges<n>::JointRanges(const ArmFacts& arm) {
  Eigen::Index k = 0;
  for (const ArmJoint& joint : arm.joints) {
    if (!joint.dh || k == n) continue;
    lower[k] = joint.lower;
    upper[k] = joint.upper;
    turns[k++] = !joint.prismatic;
  }
}

template <int n>
void JointRanges<n>::wrap(Eigen::Matrix<double, n, 1>& q,
                          const Eigen::Matrix<double, n, 1>& near) const noexcept {
  for (int k = 0; k < n; ++k) {
    if (!turns[k]) continue;
    q[k] += kTurn * std::round((near[k] - q[k]) / kTurn);
    const double above = q[k] - upper[k] - kSlack;
    const double below = lower[k] - kSlack - q[k];
    if (above > 0.0 && q[k] - kTurn * std::ceil(above / kTurn) >= lower[k] - kSlack)
      q[k] -= kTurn * std::ceil(above / kTurn);
    else if (below > 0.0 && q[k] + kTurn * std::ceil(below / kTurn) <= upper[k] + kSlack)
      q[k] += kTurn * std::ceil(below / kTurn);
  }
}

template <int n>
bool JointRanges<n>::contain(const Eigen::Matrix<double, n, 1>& q) const noexcept {
  return (q.array() >= lower.array() - kSlack).all() && (q.array() <= upper.array() + kSlack).all();
}

template struct JointRanges<3>;
template struct JointRanges<4>;
template struct JointRanges<6>;
template struct JointRanges<7>;

}  // namespace veridyn::dvrk
