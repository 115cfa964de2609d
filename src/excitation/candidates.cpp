#include "candidates.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace veridyn {
namespace {

constexpr double kSmallestShare = 0.2;  // of what the limits allow, for the motion of one joint

double sigmoid(double x) {
  return 1.0 / (1.0 + std::exp(-x));
}

}  // namespace

Candidates::Candidates(const Model& arm, const ExcitationOptions& options)
    : limits_(motion_limits(arm)),
      joints_(arm.joints()),
      harmonics_(options.harmonics),
      frequency_(options.frequency),
      share_(options.limit_share) {}

FourierTrajectory Candidates::trajectory(const VectorXd& x) const {
  const Eigen::Map<const MatrixXd> numbers(x.data(), joints_, 2 * harmonics_ + 2);
  MatrixXd a = numbers.leftCols(harmonics_);
  MatrixXd b = numbers.middleCols(harmonics_, harmonics_);
  rest_at_start(a, b);
  const MotionBounds shape = FourierTrajectory(frequency_, a, b, VectorXd::Zero(joints_)).bounds();
  VectorXd q0(joints_);
  for (int i = 0; i < joints_; ++i) {
    const double room = limits_.upper[i] - limits_.lower[i];
    const double allowed = share_ * std::min({room / (shape.upper[i] - shape.lower[i]),
                                              limits_.velocity[i] / shape.velocity[i],
                                              limits_.acceleration[i] / shape.acceleration[i]});
    const double scale =
        allowed * (kSmallestShare + (1.0 - kSmallestShare) * sigmoid(numbers(i, 2 * harmonics_)));
    a.row(i) *= scale;
    b.row(i) *= scale;
    const double edge = 0.5 * (1.0 - share_) * room;
    const double lowest = limits_.lower[i] + edge - scale * shape.lower[i];
    const double highest = limits_.upper[i] - edge - scale * shape.upper[i];
    q0[i] = lowest + (highest - lowest) * sigmoid(numbers(i, 2 * harmonics_ + 1));
  }
  return {frequency_, std::move(a), std::move(b), std::move(q0)};
}

VectorXd Candidates::random(RandomNumbers& numbers) const {
  VectorXd x(size());
  for (double& value : x) value = numbers.normal();
  x.segment(joints_ * 2 * harmonics_, joints_).array() += 2.0;
  return x;
}

}  // namespace veridyn
