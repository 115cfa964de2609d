#include "hinge_path.hpp"

#include <array>
#include <cmath>

namespace veridyn::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using RowMajor = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;
using RowMajor6 = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>;
using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajor4 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
using Plane = Eigen::Matrix<double, 3, 2>;

constexpr int kMostHinges = 32;

// Derivative of moved_line().direction, which is n, by x[0] and x[1].
Plane direction_derivative(const Line& start, const Plane& plane, const double* x,
                           const Vector3d& n) {
  const double length = (start.direction + plane * Eigen::Vector2d(x[0], x[1])).norm();
  return (plane - n * (n.transpose() * plane)) / length;
}

}  // namespace

Line moved_line(const Line& start, const Plane& plane, const double* x) {
  return {(start.direction + plane * Eigen::Vector2d(x[0], x[1])).normalized(),
          start.point + plane * Eigen::Vector2d(x[2], x[3])};
}

Vector3d rotated_about(const Line& line, double angle, const Vector3d& point) {
  return rotation_of(angle * line.direction) * (point - line.point) + line.point;
}

void HingePath::evaluate(const double* const* x, double noise, double* r, double* const* J) const {
  const int depth = static_cast<int>(hinges.size());
  const bool moves = !is_reference && (!root_rests || depth > 0);
  const double* local = moves ? x[1 + depth] : nullptr;  // a resting body has no unknowns of the frame
  const int first = root_rests ? 0 : 6;
  // From the marker to the root: points before and after each hinge.
  std::array<Line, kMostHinges> lines;
  std::array<Matrix3d, kMostHinges> R;
  std::array<Vector3d, kMostHinges + 1> y;
  std::array<double, kMostHinges> angle{};
  y[depth] = Eigen::Map<const Vector3d>(x[0]);
  for (int i = depth - 1; i >= 0; --i) {
    const auto k = static_cast<std::size_t>(i);
    lines[k] = moved_line(start[k], plane[k], x[1 + i]);
    angle[k] = moves ? local[first + hinges[k]] : 0.0;
    R[k] = rotation_of(angle[k] * lines[k].direction);
    y[k] = R[k] * (y[k + 1] - lines[k].point) + lines[k].point;
  }
  Matrix3d G = Matrix3d::Identity();
  Vector3d p = Vector3d::Zero();
  const bool free_root = !root_rests && !is_reference;
  if (free_root) {
    G = root.linear() * rotation_of(Eigen::Map<const Vector3d>(local));
    p = root.translation() + Vector3d(Eigen::Map<const Vector3d>(local + 3));
  }
  Eigen::Map<Vector3d> residual(r);
  residual = (G * y[0] + p - measured) / noise;
  if (J == nullptr) return;
  const bool wants_local = moves && J[1 + depth] != nullptr;
  if (wants_local) Eigen::Map<RowMajor>(J[1 + depth], 3, local_size).setZero();
  if (wants_local && free_root) {
    Eigen::Map<RowMajor> J_local(J[1 + depth], 3, local_size);
    J_local.leftCols<3>() =
        -G * cross_matrix(y[0]) * right_jacobian(Eigen::Map<const Vector3d>(local)) / noise;
    J_local.middleCols<3>(3) = Matrix3d::Identity() / noise;
  }
  Matrix3d L = G / noise;
  for (int i = 0; i < depth; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Vector3d& n = lines[k].direction;
    const Vector3d z = y[k + 1] - lines[k].point;
    if (wants_local)
      Eigen::Map<RowMajor>(J[1 + depth], 3, local_size).col(first + hinges[k]) =
          L * n.cross(Vector3d(R[k] * z));
    if (J[1 + i] != nullptr) {
      const double s = std::sin(angle[k]);
      const double c = 1.0 - std::cos(angle[k]);
      const Matrix3d by_n = -s * cross_matrix(z) +
                            c * (n.dot(z) * Matrix3d::Identity() + n * z.transpose());
      Eigen::Map<RowMajor4> J_line(J[1 + i]);
      J_line.leftCols<2>() = L * by_n * direction_derivative(start[k], plane[k], x[1 + i], n);
      J_line.rightCols<2>() = L * (Matrix3d::Identity() - R[k]) * plane[k];
    }
    L = L * R[k];
  }
  if (J[0] != nullptr) {
    Eigen::Map<RowMajor3> J_marker(J[0]);
    J_marker = L;
  }
}

void HingeClosure::evaluate(const double* const* x, double deviation, double* r,
                            double* const* J) const {
  const Line line = moved_line(start, plane, x[0]);
  const Plane by_direction = direction_derivative(start, plane, x[0], line.direction);
  const auto of_a = a.hinges.size();
  const auto of_b = b.hinges.size();
  const std::size_t frame = 1 + of_a + of_b;
  if (J != nullptr) {
    for (std::size_t k = 0; k <= frame; ++k) {
      const int size = k < frame ? 4 : a.local_size;
      if (J[k] != nullptr) Eigen::Map<RowMajor6>(J[k], 6, size).setZero();
    }
  }
  for (int side = 0; side < 2; ++side) {
    const double at = side == 0 ? half : -half;
    const Vector3d point = line.point + at * line.direction;
    Eigen::Matrix<double, 3, 4> by_line;
    by_line << at * by_direction, plane;
    Eigen::Map<Vector3d> gap(r + 3 * side);
    gap.setZero();
    for (const bool first : {true, false}) {
      const HingePath& path = first ? a : b;
      const double sign = first ? 1.0 : -1.0;
      const std::size_t hinges = path.hinges.size();
      const std::size_t offset = first ? 1 : 1 + of_a;  // index of its hinges in x
      std::vector<const double*> at_path = {point.data()};
      std::vector<RowMajor> blocks = {RowMajor::Zero(3, 3)};
      for (std::size_t k = 0; k < hinges; ++k) {
        at_path.push_back(x[offset + k]);
        blocks.emplace_back(RowMajor::Zero(3, 4));
      }
      at_path.push_back(x[frame]);
      blocks.emplace_back(RowMajor::Zero(3, path.local_size));
      std::vector<double*> into;
      for (RowMajor& block : blocks) into.push_back(block.data());
      Vector3d seen;
      path.evaluate(at_path.data(), deviation, seen.data(), J == nullptr ? nullptr : into.data());
      gap += sign * seen;
      if (J == nullptr) continue;
      const auto add = [&](std::size_t k, int size, const MatrixXd& block) {
        if (J[k] != nullptr)
          Eigen::Map<RowMajor6>(J[k], 6, size).middleRows(3 * side, 3) += sign * block;
      };
      add(0, 4, blocks[0] * by_line);
      for (std::size_t k = 0; k < hinges; ++k) add(offset + k, 4, blocks[1 + k]);
      add(frame, path.local_size, blocks.back());
    }
  }
}

}  // namespace veridyn::internal
