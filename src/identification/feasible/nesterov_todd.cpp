#include "identification/feasible/nesterov_todd.hpp"
#include "math/numbers.hpp"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>

namespace veridyn::cone {

using Eigen::Matrix4d;
using Eigen::Vector4d;

bool ScaledBlock::scale() {
  const Eigen::LLT<Matrix4d> factor_S(S);
  const Eigen::LLT<Matrix4d> factor_Z(Z);
  if (factor_S.info() != Eigen::Success || factor_Z.info() != Eigen::Success) return false;
  const Matrix4d L_s = factor_S.matrixL();
  const Matrix4d L_z = factor_Z.matrixL();
  const Eigen::JacobiSVD<Matrix4d> svd(L_z.transpose() * L_s,
                                       Eigen::ComputeFullU | Eigen::ComputeFullV);
  d = svd.singularValues();
  if (!(d(3) > 0.0)) return false;
  const Vector4d inverse_root = d.cwiseSqrt().cwiseInverse();
  to_scaled = inverse_root.asDiagonal() * svd.matrixU().transpose() * L_z.transpose();
  from_scaled = L_s * svd.matrixV() * inverse_root.asDiagonal();
  P = to_scaled.transpose() * to_scaled;
  return true;
}

void ScaledBlock::begin_direction(double target, bool second_order) {
  Matrix4d right = Matrix4d::Zero();
  if (second_order) right = -symmetric_part(scaled_dS * scaled_dZ);
  right.diagonal().array() += target - d.array().square();
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) right(i, j) *= 2.0 / (d(i) + d(j));
  }
  dS.setZero();
  dZ = symmetric_part(to_scaled.transpose() * right * to_scaled);
  advance_direction(residual);
}

void ScaledBlock::advance_direction(const Matrix4d& moved) {
  dS += moved;
  dZ -= symmetric_part(P * moved * P);
  scaled_dS = symmetric_part(to_scaled * dS * to_scaled.transpose());
  scaled_dZ = symmetric_part(from_scaled.transpose() * dZ * from_scaled);
}

Matrix10 block_hessian(const Matrix10& map, const Matrix4d& P) {
  static constexpr int kRow[10] = {0, 0, 0, 0, 1,
                                   1, 1, 2, 2, 3};  // entries of the upper triangle, row by row
  static constexpr int kColumn[10] = {0, 1, 2, 3, 1, 2, 3, 2, 3, 3};
  Matrix10
      K;  // K_ij = <E_i, P*E_j*P>, E_i: ones at entry i of the triangle and at its mirror image
  for (int i = 0; i < 10; ++i) {
    const int a = kRow[i];
    const int b = kColumn[i];
    for (int j = 0; j <= i; ++j) {
      const int c = kRow[j];
      const int e = kColumn[j];
      const double direct = P(a, c) * P(b, e);
      const double crossed = P(a, e) * P(b, c);
      if (a == b && c == e)
        K(i, j) = direct;
      else if (a == b || c == e)
        K(i, j) = 2.0 * direct;
      else
        K(i, j) = 2.0 * (direct + crossed);
      K(j, i) = K(i, j);
    }
  }
  return map.transpose() * K * map;
}

double relative_norm(const Matrix4d& S, const Matrix4d& change) {
  const Eigen::LLT<Matrix4d> factor(S);
  if (factor.info() != Eigen::Success) return kInfinity;
  const Matrix4d half = factor.matrixL().solve(change);
  return Matrix4d(factor.matrixL().solve(Matrix4d(half.transpose()))).norm();
}

bool stays_positive(const Vector4d& d, const Matrix4d& direction, double step) {
  Matrix4d A = step * direction;
  A.diagonal() += d;
  for (int j = 0; j < 4; ++j) {  // the pivots of L*D*L'
    if (!(A(j, j) > 0.0)) return false;
    for (int k = j + 1; k < 4; ++k) {
      const double share = A(k, j) / A(j, j);
      for (int i = k; i < 4; ++i) A(i, k) -= share * A(i, j);
    }
  }
  return true;
}

double longest_step(const Vector4d& d, const Matrix4d& direction) {
  const Vector4d inverse_root = d.cwiseSqrt().cwiseInverse();
  const double smallest =
      smallest_eigenvalue(inverse_root.asDiagonal() * direction * inverse_root.asDiagonal());
  return smallest < 0.0 ? -1.0 / smallest : kInfinity;
}

double longest_step(const VectorXd& value, const VectorXd& direction) {
  double step = kInfinity;
  for (int i = 0; i < value.size(); ++i) {
    if (direction(i) < 0.0) step = std::min(step, -value(i) / direction(i));
  }
  return step;
}

}  // namespace veridyn::cone
