#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "identification/feasible/interior_point.hpp"

namespace veridyn::cone {

using Eigen::Matrix4d;
using Eigen::Vector4d;

namespace {

constexpr double kRidge = 1e-3;  // ridge of the least squares for the initial x
constexpr double kUnseen =
    1e-26;  // a column with a squared norm this far below the largest is zero
constexpr double kSmallestSlack = 0.1;   // smallest slack, relative to the terms of the constraint
constexpr double kTypicalRadius = 0.25;  // [m] radius of gyration without other information

// Ridge regression; columns without data stay zero.
VectorXd ridge_solution(const Program& program, const MatrixXd& hessian) {
  MatrixXd M = hessian;
  const double largest = M.diagonal().maxCoeff();
  for (int j = 0; j < M.rows(); ++j) {
    if (M(j, j) > kUnseen * largest)
      M(j, j) *= 1.0 + kRidge;
    else
      M(j, j) = largest > 0.0 ? largest : 1.0;
  }
  return M.selfadjointView<Eigen::Lower>().llt().solve(2.0 * (program.R.transpose() * program.z));
}

struct Body {
  double mass = 0.0;
  double radius = kTypicalRadius;
};

// Mass and size from the box if there is one, else from the least squares.
Body typical_body(const Box& box, const VectorXd& x, int column, double other_mass) {
  Body body;
  const double lower = box.lower(column);
  const double upper = box.upper(column);
  if (std::isfinite(upper) && upper > 0.0)
    body.mass = 0.5 * (std::max(lower, 0.0) + upper);
  else
    body.mass = std::max(x(column), std::isfinite(lower) ? 2.0 * lower : 0.0);
  if (!(body.mass > 0.0)) body.mass = other_mass;
  const Eigen::Vector3d reach = box.upper.segment<3>(column + 1);
  double radius = reach.maxCoeff() / body.mass;
  if (!std::isfinite(radius)) {
    const double trace = x(column + 4) + x(column + 6) + x(column + 9);
    radius = std::max(x.segment<3>(column + 1).norm() / body.mass,
                      std::sqrt(std::max(trace, 0.0) / body.mass));
  }
  if (radius > 0.0 && std::isfinite(radius)) body.radius = radius;
  return body;
}

void place_bodies(const Program& program, VectorXd& x, VectorXd& size) {
  double largest_mass = 0.0;
  for (const Block& block : program.blocks) largest_mass = std::max(largest_mass, x(block.column));
  const VectorXd seen = x;
  for (const Block& block : program.blocks) {
    const int k = block.column;
    if (block.log_det_weight > 0.0) {
      x.segment<10>(k) = block.prior;
      continue;
    }
    const Body body = typical_body(program.box, seen, k, largest_mass > 0.0 ? largest_mass : 1.0);
    const double h = body.mass * body.radius;
    const double inertia = h * body.radius;
    x.segment<10>(k) << body.mass, 0.0, 0.0, 0.0, inertia, 0.0, inertia, 0.0, 0.0, inertia;
    size.segment<10>(k) << body.mass, h, h, h, inertia, inertia, inertia, inertia, inertia, inertia;
  }
}

ScaledBlock block_start(const Block& block, const VectorXd& x, double mu) {
  const Matrix4d J = block.slack(x);
  const double largest = J.diagonal().cwiseAbs().maxCoeff();
  const Vector4d scale =
      J.diagonal().cwiseAbs().cwiseMax(largest > 0.0 ? 1e-9 * largest : 1.0).cwiseSqrt();
  const Vector4d inverse = scale.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Matrix4d> eigen(
      Matrix4d(inverse.asDiagonal() * J * inverse.asDiagonal()));
  const Vector4d values = eigen.eigenvalues().cwiseMax(kSmallestSlack);
  const Matrix4d V = scale.asDiagonal() * eigen.eigenvectors();
  const Matrix4d W = inverse.asDiagonal() * eigen.eigenvectors();
  ScaledBlock state;
  state.S = symmetric_part(V * values.asDiagonal() * V.transpose());
  state.Z = symmetric_part(W * (mu * values.cwiseInverse()).asDiagonal() * W.transpose());
  return state;
}

}  // namespace

Start starting_point(const Program& program, const MatrixXd& hessian, double cost_floor,
                     double first_gap) {
  Start start;
  VectorXd& x = start.x;
  x = ridge_solution(program, hessian);
  for (int j = 0; j < x.size(); ++j) {
    const double middle = 0.5 * (program.box.lower(j) + program.box.upper(j));
    if (std::isfinite(middle)) x(j) = middle;
  }
  VectorXd size = x.cwiseAbs();
  for (int j = 0; j < x.size(); ++j) {
    const double width = program.box.upper(j) - program.box.lower(j);
    if (std::isfinite(width)) size(j) = 0.5 * std::abs(width);
  }
  place_bodies(program, x, size);

  const double squares = std::max((program.R * x - program.z).squaredNorm(), cost_floor);
  const double degree = std::max(1.0, static_cast<double>(program.rows.size()) + 4.0 * static_cast<double>(program.blocks.size()));
  const double mu = first_gap * squares / degree;
  start.slack = program.rows.slack(x);
  for (int i = 0; i < program.rows.size(); ++i) {
    double scale = std::abs(program.rows.bound(i));
    for (int a = program.rows.start[i]; a < program.rows.start[i + 1]; ++a) {
      scale += std::abs(program.rows.value[a]) * size(program.rows.column[a]);
    }
    start.slack(i) = std::max(start.slack(i), kSmallestSlack * (scale > 0.0 ? scale : 1.0));
  }
  start.lambda = mu * start.slack.cwiseInverse();
  for (const Block& block : program.blocks) {
    start.blocks.push_back(block_start(block, x, std::max(mu, block.log_det_weight)));
  }
  return start;
}

}  // namespace veridyn::cone
