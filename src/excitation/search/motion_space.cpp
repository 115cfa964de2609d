#include "excitation/search/motion_space.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

namespace veridyn {
namespace {

// An orthonormal basis of the complement of v.
MatrixXd complement(const VectorXd& v) {
  const MatrixXd Q = Eigen::HouseholderQR<MatrixXd>(v).householderQ();
  return Q.rightCols(v.size() - 1);
}

}  // namespace

MotionSpace::MotionSpace(MotionLimits limits, int harmonics, double frequency)
    : limits_(std::move(limits)),
      harmonics_(harmonics),
      frequency_(frequency),
      middle_(0.5 * (limits_.lower + limits_.upper)),
      size_(0.5 * (limits_.upper - limits_.lower)),
      a_basis_(complement(VectorXd::Ones(harmonics))),
      b_basis_(complement(VectorXd::LinSpaced(harmonics, 1.0, harmonics))) {}

FourierTrajectory MotionSpace::trajectory(const VectorXd& x) const {
  const int free = harmonics_ - 1;
  MatrixXd a(joints(), harmonics_);
  MatrixXd b(joints(), harmonics_);
  VectorXd q0(joints());
  for (int i = 0; i < joints(); ++i) {
    const VectorXd own = x.segment(i * per_joint(), per_joint());
    const double unit = 2.0 * M_PI * frequency_ * size_[i];
    q0[i] = middle_[i] + size_[i] * own[0];
    a.row(i) = unit * (a_basis_ * own.segment(1, free)).transpose();
    b.row(i) = unit * (b_basis_ * own.tail(free)).transpose();
  }
  return {frequency_, std::move(a), std::move(b), std::move(q0)};
}

MotionSpace::Basis MotionSpace::basis(const VectorXd& time) const {
  const FourierBasis waves(time, frequency_, harmonics_);
  const double unit = 2.0 * M_PI * frequency_;
  const Eigen::Index free = harmonics_ - 1;
  const Eigen::Index rows = time.size();
  Basis out{time, MatrixXd(rows, per_joint()), MatrixXd(rows, per_joint()),
            MatrixXd(rows, per_joint())};
  out.q.col(0).setOnes();
  out.dq.col(0).setZero();
  out.ddq.col(0).setZero();
  const auto by_omega = waves.omega.cwiseInverse().asDiagonal();
  out.q.middleCols(1, free) = unit * (waves.sine * (by_omega * a_basis_));
  out.q.rightCols(free) = -unit * (waves.cosine * (by_omega * b_basis_));
  out.dq.middleCols(1, free) = unit * (waves.cosine * a_basis_);
  out.dq.rightCols(free) = unit * (waves.sine * b_basis_);
  out.ddq.middleCols(1, free) = -unit * (waves.sine * (waves.omega.asDiagonal() * a_basis_));
  out.ddq.rightCols(free) = unit * (waves.cosine * (waves.omega.asDiagonal() * b_basis_));
  return out;
}

MotionSamples MotionSpace::samples(const Basis& basis, const VectorXd& x) const {
  const Eigen::Map<const MatrixXd> X(x.data(), per_joint(), joints());
  const MatrixXd sized = X * size_.asDiagonal();
  MotionSamples out{basis.time, basis.q * sized, basis.dq * sized, basis.ddq * sized};
  out.q.rowwise() += middle_.transpose();
  return out;
}

VectorXd MotionSpace::gradient(const Basis& basis, const MatrixXd& slopes) const {
  const Eigen::Index n = joints();
  const MatrixXd by_x =
      (basis.q.transpose() * slopes.leftCols(n) + basis.dq.transpose() * slopes.middleCols(n, n) +
       basis.ddq.transpose() * slopes.rightCols(n)) *
      size_.asDiagonal();
  return by_x.reshaped();
}

double MotionSpace::allowed(const VectorXd& x, int joint) const {
  VectorXd still = x;
  for (int i = 0; i < joints(); ++i) still[i * per_joint()] = 0.0;
  const FourierTrajectory t = trajectory(still);
  const MotionBounds b = t.bounds();
  return std::min(
      {(limits_.upper[joint] - limits_.lower[joint]) / (b.upper[joint] - b.lower[joint]),
       limits_.velocity[joint] / b.velocity[joint],
       limits_.acceleration[joint] / b.acceleration[joint]});
}

VectorXd MotionSpace::random(RandomNumbers& numbers) const {
  VectorXd x(size());
  for (double& value : x) value = numbers.normal();
  for (int i = 0; i < joints(); ++i) {
    const double scale = numbers.uniform(0.6, 0.98) * allowed(x, i);
    auto own = x.segment(i * per_joint(), per_joint());
    own *= scale;
    own[0] = 0.0;
  }
  const MotionBounds b = trajectory(x).bounds();
  for (int i = 0; i < joints(); ++i) {
    const double lowest = limits_.lower[i] - b.lower[i];
    const double highest = limits_.upper[i] - b.upper[i];
    x[i * per_joint()] = numbers.uniform(lowest, std::max(lowest, highest)) / size_[i];
  }
  return x;
}

}  // namespace veridyn
