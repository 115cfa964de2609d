#include "closed_forms.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "veridyn/math/dense.hpp"

namespace veridyn::internal {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kSmallAngle = 1e-6;  // [rad] smallest angle for which the second-order series is not used

// Root mean square, from squares, without the largest twentieth: a few wrong poses do not decide about a hinge.
double trimmed_rms(std::vector<double> squares) {
  std::sort(squares.begin(), squares.end());
  const std::size_t kept = std::max<std::size_t>(1, squares.size() - squares.size() / 20);
  double sum = 0.0;
  for (std::size_t k = 0; k < kept; ++k) sum += squares[k];
  return std::sqrt(sum / static_cast<double>(kept));
}

// Computes wobble, play and slide of an axis from the relative poses.
void set_axis_residuals(const Isometries& T_a_b, CommonAxis& axis) {
  std::vector<double> wobble;
  std::vector<double> play;
  std::vector<double> slide;
  for (const Isometry3d& T : T_a_b) {
    const Vector3d off = T * axis.in_b.point - axis.in_a.point;
    const double along = off.dot(axis.in_a.direction);
    const Vector3d turn = T.linear() * axis.in_b.direction - axis.in_a.direction;
    const Vector3d across = off - along * axis.in_a.direction;
    wobble.push_back(turn.squaredNorm());
    slide.push_back(along * along);
    play.push_back(across.squaredNorm());
  }
  axis.wobble = trimmed_rms(wobble);
  axis.play = trimmed_rms(play);
  axis.slide = trimmed_rms(slide);
}

}  // namespace

Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d S;
  // clang-format off
  S <<      0, -v.z(),  v.y(),
        v.z(),      0, -v.x(),
       -v.y(),  v.x(),      0;
  // clang-format on
  return S;
}

Vector3d rotation_vector(const Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

Matrix3d rotation_of(const Vector3d& w) {
  const double angle = w.norm();
  if (angle < kSmallAngle) {
    const Matrix3d S = cross_matrix(w);
    return Matrix3d::Identity() + S + 0.5 * S * S;
  }
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

Matrix3d left_jacobian_inverse(const Vector3d& w) {
  const double angle = w.norm();
  const Matrix3d S = cross_matrix(w);
  const double c = angle < 1e-3 ? 1.0 / 12.0
                                : 1.0 / (angle * angle) - (1.0 + std::cos(angle)) /
                                                              (2.0 * angle * std::sin(angle));
  return Matrix3d::Identity() - 0.5 * S + c * S * S;
}

Matrix3d right_jacobian(const Vector3d& w) {
  const double angle = w.norm();
  const Matrix3d S = cross_matrix(w);
  if (angle < kSmallAngle) return Matrix3d::Identity() - 0.5 * S;
  const double square = angle * angle;
  return Matrix3d::Identity() - (1.0 - std::cos(angle)) / square * S +
         (angle - std::sin(angle)) / (square * angle) * S * S;
}

Matrix3d nearest_rotation(const Matrix3d& M) {
  const Eigen::JacobiSVD<Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d D = Matrix3d::Identity();
  D(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * D * svd.matrixV().transpose();
}

Isometry3d fitted_pose(const MatrixRef& a, const MatrixRef& b) {
  const Vector3d mean_a = a.rowwise().mean();
  const Vector3d mean_b = b.rowwise().mean();
  const Matrix3d C = (b.colwise() - mean_b) * (a.colwise() - mean_a).transpose();
  Isometry3d T = Isometry3d::Identity();
  T.linear() = nearest_rotation(C);
  T.translation() = mean_b - T.linear() * mean_a;
  return T;
}

RotationSpread rotation_spread(const Isometries& poses) {
  Matrix3d mean = Matrix3d::Zero();
  for (const Isometry3d& T : poses) mean += T.linear();
  mean /= static_cast<double>(poses.size());
  const Matrix3d M = Matrix3d::Identity() - mean.transpose() * mean;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(M);
  return {eigen.eigenvalues().cwiseMax(0.0), eigen.eigenvectors(), mean};
}

CommonAxis common_axis(const Isometries& T_a_b) {
  const RotationSpread spread = rotation_spread(T_a_b);
  CommonAxis axis;
  axis.in_b.direction = spread.axes.col(0);
  axis.in_a.direction = (spread.mean * axis.in_b.direction).normalized();
  Vector3d mean_p = Vector3d::Zero();
  for (const Isometry3d& T : T_a_b) mean_p += T.translation();
  mean_p /= static_cast<double>(T_a_b.size());
  // The point with the least motion, determined across the axis only: R c + p is the same in all poses.
  const Eigen::Matrix<double, 3, 2> across = spread.axes.rightCols<2>();
  Eigen::Matrix2d N = Eigen::Matrix2d::Zero();
  Eigen::Vector2d g = Eigen::Vector2d::Zero();
  for (const Isometry3d& T : T_a_b) {
    const Eigen::Matrix<double, 3, 2> D = (T.linear() - spread.mean) * across;
    N += D.transpose() * D;
    g -= D.transpose() * (T.translation() - mean_p);
  }
  axis.in_b.point = across * symmetric_solution(N, g);
  axis.in_a.point = spread.mean * axis.in_b.point + mean_p;
  set_axis_residuals(T_a_b, axis);
  return axis;
}

HandAndWorld hand_and_world(const Isometries& A, const Isometries& B) {
  // R_X = R_A' R_Y R_B, with vec(P X Q) = (Q' kron P) vec(X).
  Eigen::Matrix<double, 9, 9> K = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t k = 0; k < A.size(); ++k) {
    const Matrix3d Q = B[k].linear().transpose();
    const Matrix3d P = A[k].linear().transpose();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) K.block<3, 3>(3 * i, 3 * j) += Q(i, j) * P;
    }
  }
  const Eigen::JacobiSVD<MatrixXd> svd(K, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d M_X = Eigen::Map<const Matrix3d>(svd.matrixU().col(0).data());
  Matrix3d M_Y = Eigen::Map<const Matrix3d>(svd.matrixV().col(0).data());
  if (M_X.determinant() < 0.0) {
    M_X = -M_X;
    M_Y = -M_Y;
  }
  HandAndWorld out{Isometry3d::Identity(), Isometry3d::Identity()};
  out.X.linear() = nearest_rotation(M_X);
  out.Y.linear() = nearest_rotation(M_Y);
  MatrixXd N(3 * static_cast<Eigen::Index>(A.size()), 6);
  VectorXd b(N.rows());
  for (std::size_t k = 0; k < A.size(); ++k) {
    const auto row = 3 * static_cast<Eigen::Index>(k);
    N.block<3, 3>(row, 0) = A[k].linear();
    N.block<3, 3>(row, 3) = -Matrix3d::Identity();
    b.segment<3>(row) = out.Y.linear() * B[k].translation() - A[k].translation();
  }
  const VectorXd t = least_squares_solution(N, b);
  out.X.translation() = t.head<3>();
  out.Y.translation() = t.tail<3>();
  return out;
}

Isometry3d solve_hand_eye(const Isometries& A, const Isometries& B) {
  Matrix3d M = Matrix3d::Zero();
  for (std::size_t k = 0; k < A.size(); ++k)
    M += rotation_vector(A[k].linear()) * rotation_vector(B[k].linear()).transpose();
  Isometry3d X = Isometry3d::Identity();
  X.linear() = nearest_rotation(M);
  MatrixXd N(3 * static_cast<Eigen::Index>(A.size()), 3);
  VectorXd b(N.rows());
  for (std::size_t k = 0; k < A.size(); ++k) {
    const auto row = 3 * static_cast<Eigen::Index>(k);
    N.middleRows<3>(row) = A[k].linear() - Matrix3d::Identity();
    b.segment<3>(row) = X.linear() * B[k].translation() - A[k].translation();
  }
  X.translation() = least_squares_solution(N, b);
  return X;
}

}  // namespace veridyn::internal
