#include "veridyn/control/task_inverse.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "kinematics/motion_limits.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

double characteristic_length(const Model& arm, const Tip& tip) {
  TipKinematics kinematics(arm, tip);
  const MotionLimits limits = motion_limits(arm);
  const VectorXd middle = 0.5 * (limits.lower + limits.upper);
  kinematics.update(middle, VectorXd::Zero(arm.joints()));
  const MatrixXd& J = kinematics.jacobian();
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < arm.joints(); ++i) {
    const double swept = J.col(i).head<3>().squaredNorm();
    if (arm.coordinates()[i].prismatic || swept < 1e-12) continue;
    sum += swept;
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : 1.0;
}

TaskInverse::TaskInverse(const Model& arm, const Tip& tip, TaskRows rows,
                         const TaskInverseOptions& options)
    : rows_(static_cast<int>(rows)),
      length_(options.length > 0.0 ? options.length : characteristic_length(arm, tip)),
      threshold_(options.threshold),
      unit_(VectorXd::Ones(arm.joints())),
      held_(static_cast<size_t>(arm.joints()), 0),
      J_(MatrixXd::Zero(static_cast<int>(rows), arm.joints())) {
  require(options.length >= 0.0 && std::isfinite(options.length) && options.threshold > 0.0 &&
              std::isfinite(options.threshold),
          "TaskInverse: found a length of ", options.length, " m and a threshold of ",
          options.threshold, ", expected none below zero and a threshold above it.");
  for (int i = 0; i < arm.joints(); ++i) {
    if (arm.coordinates()[i].prismatic) unit_[i] = length_;
  }
  U_.setIdentity();
  gain_.setZero();
}

namespace {

// Factors A - shift 1 = L L' with 1 / L_kk on the diagonal; the part above it is not changed. False if the
// matrix is not positive definite, that is, if some eigenvalue of A is not above the shift.
template <int kRows>
bool cholesky(const Eigen::Matrix<double, kRows, kRows>& A, double shift,
              Eigen::Matrix<double, 6, 6>& L) {
  for (int j = 0; j < kRows; ++j) {
    double pivot = A(j, j) - shift;
    for (int k = 0; k < j; ++k) pivot -= L(j, k) * L(j, k);
    if (!(pivot > 0.0)) return false;
    L(j, j) = 1.0 / std::sqrt(pivot);
    for (int i = j + 1; i < kRows; ++i) {
      double sum = A(i, j);
      for (int k = 0; k < j; ++k) sum -= L(i, k) * L(j, k);
      L(i, j) = sum * L(j, j);
    }
  }
  return true;
}

}  // namespace

// If all singular values are above the threshold, no direction is damped, and the eigenvectors, which cost
// ten times a Cholesky factor, are not needed.
template <int kRows>
void TaskInverse::factor() noexcept {
  Eigen::Matrix<double, kRows, kRows> square;
  square.noalias() = J_.topRows<kRows>().lazyProduct(J_.topRows<kRows>().transpose());
  const double least = threshold_ * threshold_;
  near_singular_ = !cholesky<kRows>(square, least, U_);
  if (!near_singular_) {
    cholesky<kRows>(square, 0.0, U_);
    return;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kRows, kRows>> solver(square);
  U_.template topLeftCorner<kRows, kRows>() = solver.eigenvectors();
  for (int k = 0; k < kRows; ++k)
    gain_[k] = 1.0 / std::max(solver.eigenvalues()[k], least);
}

double TaskInverse::smallest_singular_value() const noexcept {
  Eigen::Matrix<double, 6, 6> square = Eigen::Matrix<double, 6, 6>::Zero();
  square.topLeftCorner(rows_, rows_).noalias() = J_.lazyProduct(J_.transpose());
  // The diagonal of unused rows is set to the trace, so that they do not have the smallest singular value.
  for (int r = rows_; r < 6; ++r) square(r, r) = square.trace();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(square, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(solver.eigenvalues()[0], 0.0));
}

void TaskInverse::update(const MatrixXd& J) noexcept {
  assert(J.rows() >= rows_ && J.cols() == J_.cols());
  for (Eigen::Index i = 0; i < J_.cols(); ++i) {
    const double unit = held(static_cast<int>(i)) ? 0.0 : unit_[i];
    for (int r = 0; r < rows_; ++r) J_(r, i) = J(r, i) * (r < 3 ? unit / length_ : unit);
  }
  if (rows_ == 3)
    factor<3>();
  else
    factor<6>();
}

// The product (J~ J~')^-1 a, with the damping.
Vector6d TaskInverse::weigh(const Vector6d& a) const noexcept {
  Vector6d out = Vector6d::Zero();
  if (!near_singular_) {
    for (int r = 0; r < rows_; ++r) {
      double sum = a[r];
      for (int k = 0; k < r; ++k) sum -= U_(r, k) * out[k];
      out[r] = sum * U_(r, r);
    }
    for (int r = rows_ - 1; r >= 0; --r) {
      double sum = out[r];
      for (int k = r + 1; k < rows_; ++k) sum -= U_(k, r) * out[k];
      out[r] = sum * U_(r, r);
    }
    return out;
  }
  for (int k = 0; k < rows_; ++k) {
    double along = 0.0;
    for (int r = 0; r < rows_; ++r) along += U_(r, k) * a[r];
    along *= gain_[k];
    for (int r = 0; r < rows_; ++r) out[r] += along * U_(r, k);
  }
  return out;
}

void TaskInverse::solve_wrench(const VectorRef& tau, Vector6d& h) noexcept {
  assert(tau.size() == J_.cols());
  Vector6d moved = Vector6d::Zero();
  for (Eigen::Index i = 0; i < J_.cols(); ++i) {
    for (int r = 0; r < rows_; ++r) moved[r] += J_(r, i) * unit_[i] * tau[i];
  }
  h = weigh(moved);
  for (int r = 0; r < std::min(rows_, 3); ++r) h[r] /= length_;
}

void TaskInverse::solve(const Vector6d& a, const VectorRef& y0, VectorXd& y) noexcept {
  assert(y0.size() == J_.cols() && y.size() == J_.cols());
  // Subtracts the component of the posture that affects the task.
  Vector6d rest = a;
  for (int r = 0; r < rows_; ++r) {
    if (r < 3) rest[r] /= length_;
    for (Eigen::Index i = 0; i < J_.cols(); ++i) rest[r] -= J_(r, i) * y0[i] / unit_[i];
  }
  const Vector6d turned = weigh(rest);
  for (Eigen::Index i = 0; i < J_.cols(); ++i) {
    double sum = 0.0;
    for (int r = 0; r < rows_; ++r) sum += J_(r, i) * turned[r];
    y[i] = held(static_cast<int>(i)) ? 0.0 : y0[i] + unit_[i] * sum;
  }
}

}  // namespace veridyn
