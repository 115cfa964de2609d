#include "contradiction.hpp"

#include <fmt/format.h>

#include <cmath>

#include "deviations.hpp"

namespace veridyn::internal {
namespace {

// [m], [rad] residual that is never a contradiction_reason, however little the poses vary: a body with its origin at
// the remote centre hardly moves.
constexpr double kCloseFit = 0.005;
constexpr double kCloseTurn = 2.0 * kDegree;

}  // namespace

std::string contradiction_reason(const Isometries& poses, const FitResiduals& left) {
  if (2 * left.outliers > static_cast<int>(poses.size()))
    return fmt::format("{} of {} poses, more than half, contradict any answer", left.outliers, poses.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Isometry3d& T : poses) mean += T.translation() / static_cast<double>(poses.size());
  double squares = 0.0;
  for (const Eigen::Isometry3d& T : poses) squares += (T.translation() - mean).squaredNorm();
  const double travel = std::sqrt(squares / static_cast<double>(poses.size()));
  // The mean square displacement of unit vectors is twice that of a small angle.
  const double turn = std::sqrt(0.5 * rotation_spread(poses).eigenvalues.sum());
  if ((left.rms <= kCloseFit || 2.0 * left.rms <= travel) &&
      (left.angle <= kCloseTurn || 2.0 * left.angle <= turn))
    return "";
  const auto both = [&](double metres, double radians) {
    return fmt::format("{:.3g} mm", 1e3 * metres) +
           (left.angle > 0.0 ? fmt::format(" and {:.3g} deg", radians / kDegree) : "");
  };
  return "the poses contradict any answer: it leaves " + both(left.rms, left.angle) + " rms of poses that vary by " +
         both(travel, turn);
}

}  // namespace veridyn::internal
