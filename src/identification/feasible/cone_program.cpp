#include "identification/feasible/cone_program.hpp"
#include "math/numbers.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace veridyn::cone {

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

InertialVector upper_triangle(const Eigen::Matrix4d& S) {
  InertialVector s;
  s << S(0, 0), S(0, 1), S(0, 2), S(0, 3), S(1, 1), S(1, 2), S(1, 3), S(2, 2), S(2, 3), S(3, 3);
  return s;
}

Eigen::Matrix4d from_upper_triangle(const InertialVector& s) {
  Eigen::Matrix4d S;
  // clang-format off
  S << s(0), s(1), s(2), s(3),
       s(1), s(4), s(5), s(6),
       s(2), s(5), s(7), s(8),
       s(3), s(6), s(8), s(9);
  // clang-format on
  return S;
}

// One pass over the rows: bounds each variable by the extreme values of the others.
void tighten_by_rows(const SparseRows& rows, Box& box) {
  for (int i = 0; i < rows.size(); ++i) {
    for (int a = rows.start[i]; a < rows.start[i + 1]; ++a) {
      double room = rows.bound(i);
      for (int b = rows.start[i]; b < rows.start[i + 1]; ++b) {
        if (b == a) continue;
        const double value = rows.value[b];
        room -= value * (value > 0.0 ? box.lower : box.upper)(rows.column[b]);
      }
      if (!std::isfinite(room)) continue;
      const int j = rows.column[a];
      const double limit = room / rows.value[a];
      if (rows.value[a] > 0.0) box.upper(j) = std::min(box.upper(j), limit);
      if (rows.value[a] < 0.0) box.lower(j) = std::max(box.lower(j), limit);
    }
  }
}

// |A_ij| <= sqrt(A_ii*A_jj); every entry of A is one variable or, for Sigma, is bounded by moments of
// inertia.
void tighten_by_block(const Block& block, Box& box) {
  auto lower = box.lower.segment<10>(block.column);
  auto upper = box.upper.segment<10>(block.column);
  for (const int j : {0, 4, 6, 9}) lower(j) = std::max(lower(j), 0.0);
  const auto limit = [&](int j, double bound) {
    lower(j) = std::max(lower(j), -bound);
    upper(j) = std::min(upper(j), bound);
  };
  if (!block.is_pseudo_inertia) {
    limit(5, std::sqrt(upper(4) * upper(6)));
    limit(7, std::sqrt(upper(4) * upper(9)));
    limit(8, std::sqrt(upper(6) * upper(9)));
    return;
  }
  upper(4) = std::min(upper(4), upper(6) + upper(9));
  upper(6) = std::min(upper(6), upper(4) + upper(9));
  upper(9) = std::min(upper(9), upper(4) + upper(6));
  limit(5, 0.5 * upper(9));  // Sigma_xx + Sigma_yy = Izz
  limit(7, 0.5 * upper(6));
  limit(8, 0.5 * upper(4));
  limit(1, std::sqrt(upper(0) * std::min(upper(6), upper(9))));  // Sigma_xx <= Iyy, Izz
  limit(2, std::sqrt(upper(0) * std::min(upper(4), upper(9))));
  limit(3, std::sqrt(upper(0) * std::min(upper(4), upper(6))));
}

}  // namespace

Eigen::Matrix4d Block::apply(const VectorXd& direction) const {
  return from_upper_triangle(map * direction.segment<10>(column));
}

Eigen::Matrix4d Block::slack(const VectorXd& x) const {
  Eigen::Matrix4d S = apply(x);
  S.diagonal().array() -= margin;
  return S;
}

InertialVector Block::adjoint(const Eigen::Matrix4d& Z) const {
  Eigen::Matrix4d doubled = Z + Z.transpose();
  doubled.diagonal() = Z.diagonal();
  return map.transpose() * upper_triangle(doubled);
}

Block make_block(int column, PhysicalCondition condition) {
  Block block;
  block.column = column;
  block.is_pseudo_inertia = condition != PhysicalCondition::kPrincipalMoments;
  for (int j = 0; j < 10; ++j) {
    const InertialVector unit = InertialVector::Unit(j);
    block.map.col(j) = upper_triangle(block.is_pseudo_inertia ? pseudo_inertia(unit)
                                                              : principal_moment_matrix(unit));
  }
  return block;
}

Eigen::Matrix4d pseudo_inertia_from_adjoint(const InertialVector& phi) {
  const double half_trace = phi(4) + phi(6) + phi(9);
  Eigen::Matrix4d Z;
  // clang-format off
  Z << half_trace - phi(4), -0.5 * phi(5),       -0.5 * phi(7),       0.5 * phi(1),
       -0.5 * phi(5),       half_trace - phi(6), -0.5 * phi(8),       0.5 * phi(2),
       -0.5 * phi(7),       -0.5 * phi(8),       half_trace - phi(9), 0.5 * phi(3),
       0.5 * phi(1),        0.5 * phi(2),        0.5 * phi(3),        phi(0);
  // clang-format on
  return Z;
}

double Box::reach(int j) const {
  const double width = upper(j) - lower(j);
  if (!std::isfinite(width)) return trusted(j);
  return trusted(j) > 0.0 ? std::min(width, trusted(j)) : width;
}

bool met_to_rounding(const Program& program, const VectorXd& x) {
  constexpr double kSmallPart = 1e-7;
  if (!x.allFinite()) return false;
  const SparseRows& rows = program.rows;
  for (int i = 0; i < rows.size(); ++i) {
    double terms = std::abs(rows.bound(i));
    for (int a = rows.start[i]; a < rows.start[i + 1]; ++a) {
      terms += std::abs(rows.value[a] * x(rows.column[a]));
    }
    if (rows.bound(i) - rows.dot(i, x) < -kSmallPart * terms) return false;
  }
  return std::all_of(program.blocks.begin(), program.blocks.end(), [&](const Block& block) {
    const Eigen::Matrix4d S = block.slack(x);
    return smallest_eigenvalue(S) >= -kSmallPart * S.cwiseAbs().maxCoeff();
  });
}

double cost(const Program& program, const VectorXd& x) {
  return cost(program, x, program.R * x - program.z);
}

double cost(const Program& program, const VectorXd& x, const VectorXd& residual) {
  double value = residual.squaredNorm() + program.linear.dot(x) + program.constant;
  for (const Block& block : program.blocks) {
    if (block.log_det_weight == 0.0) continue;
    const Eigen::LLT<Eigen::Matrix4d> factor(block.slack(x));
    if (factor.info() != Eigen::Success) return kInfinity;
    value -= 2.0 * block.log_det_weight * factor.matrixLLT().diagonal().array().log().sum();
  }
  return value;
}

double SparseRows::dot(int row, const VectorXd& x) const {
  double sum = 0.0;
  for (int a = start[row]; a < start[row + 1]; ++a) sum += value[a] * x(column[a]);
  return sum;
}

VectorXd SparseRows::slack(const VectorXd& x) const {
  VectorXd s = bound;
  for (int i = 0; i < size(); ++i) s(i) -= dot(i, x);
  return s;
}

void SparseRows::add_transposed(const VectorXd& lambda, VectorXd& result) const {
  for (int i = 0; i < size(); ++i) {
    for (int a = start[i]; a < start[i + 1]; ++a) result(column[a]) += value[a] * lambda(i);
  }
}

SparseRows sparse_rows(const MatrixXd& G, const VectorXd& h) {
  SparseRows rows;
  rows.bound = h;
  for (int i = 0; i < h.size(); ++i) {
    for (int j = 0; j < G.cols(); ++j) {
      if (G(i, j) == 0.0) continue;
      rows.column.push_back(j);
      rows.value.push_back(G(i, j));
    }
    rows.start.push_back(static_cast<int>(rows.column.size()));
  }
  return rows;
}

Box implied_box(const SparseRows& rows, const std::vector<Block>& blocks, int variables) {
  constexpr int kPasses = 3;  // m, then h from m, then the bounds that follow from h
  Box box;
  box.lower = VectorXd::Constant(variables, -kInfinity);
  box.upper = VectorXd::Constant(variables, kInfinity);
  for (int pass = 0; pass < kPasses; ++pass) {
    for (const Block& block : blocks) tighten_by_block(block, box);
    tighten_by_rows(rows, box);
  }
  return box;
}

double gain_over_box(const Program& program, const VectorXd& x, const VectorXd& c,
                     const VectorXd& error, std::vector<int>& unbounded_columns) {
  const Box& box = program.box;
  double gain = 0.0;
  for (int j = 0; j < x.size(); ++j) {
    const double down = std::max(c(j) + error(j), 0.0);
    const double up = std::max(error(j) - c(j), 0.0);
    if (down == 0.0 && up == 0.0) continue;
    const double below = x(j) - box.lower(j);
    const double above = box.upper(j) - x(j);
    if ((down > 0.0 && !std::isfinite(below)) || (up > 0.0 && !std::isfinite(above))) {
      unbounded_columns.push_back(j);
    }
    const double room_below = std::isfinite(below) ? below : 2.0 * std::abs(x(j)) + box.trusted(j);
    const double room_above = std::isfinite(above) ? above : 2.0 * std::abs(x(j)) + box.trusted(j);
    gain += std::max({down * room_below, up * room_above, 0.0});
  }
  return gain;
}

namespace {

// G'*lambda - sum of adjoint(Z), and a bound of its rounding error.
VectorXd dual_gradient(const Program& program, const Point& point, VectorXd& error) {
  VectorXd c = VectorXd::Zero(program.variables());
  program.rows.add_transposed(point.lambda, c);
  const double rounding = 0.5 * kEpsilon * (2.0 + program.rows.size());
  for (int i = 0; i < program.rows.size(); ++i) {
    for (int a = program.rows.start[i]; a < program.rows.start[i + 1]; ++a) {
      error(program.rows.column[a]) += rounding * std::abs(program.rows.value[a]) * point.lambda(i);
    }
  }
  for (size_t k = 0; k < program.blocks.size(); ++k) {
    const Block& block = program.blocks[k];
    c.segment<10>(block.column) -= block.adjoint(point.Z[k]);
    error.segment<10>(block.column).array() += 4.0 * kEpsilon * point.Z[k].trace();
  }
  return c;
}

// cost term + its conjugate: tr(S*Z) on the cone; with a log-det term, the excess over its minimum.
double block_gap(const Block& block, const Eigen::Matrix4d& S, const Eigen::Matrix4d& Z) {
  const double weight = block.log_det_weight;
  if (weight == 0.0) return (S.cwiseProduct(Z)).sum();
  const Eigen::LLT<Eigen::Matrix4d> factor(S);
  const Eigen::Matrix4d L = factor.matrixL();
  const Eigen::Matrix4d both = L.transpose() * Z * L;
  const Eigen::Vector4d ratio =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(both, Eigen::EigenvaluesOnly).eigenvalues() / weight;
  if (!(ratio(0) > 0.0)) return kInfinity;
  return weight * (ratio.array() - ratio.array().log() - 1.0).sum();
}

}  // namespace

Bound duality_gap(const Program& program, const Point& point, const VectorXd& residual) {
  // A dot product of length l is off by at most l*kEpsilon/2 of the sum of its absolute terms.
  const double rounding =
      0.5 * kEpsilon * (2.0 + static_cast<double>(std::max<Eigen::Index>(program.variables(), residual.size())));
  VectorXd error = 2.0 * rounding * (program.R.cwiseAbs().transpose() * residual.cwiseAbs());
  const VectorXd c = dual_gradient(program, point, error);
  const VectorXd gradient = 2.0 * (program.R.transpose() * residual) + program.linear + c;

  Bound bound;
  bound.gap = gain_over_box(program, point.x, gradient, error, bound.unbounded_columns);
  const VectorXd size = program.R.cwiseAbs() * point.x.cwiseAbs() + program.z.cwiseAbs();
  bound.gap += 2.0 * rounding * residual.cwiseAbs().dot(size);
  const VectorXd slack = program.rows.slack(point.x);
  bound.gap +=
      slack.dot(point.lambda) + 4.0 * kEpsilon * program.rows.bound.cwiseAbs().dot(point.lambda);
  for (size_t k = 0; k < program.blocks.size(); ++k) {
    bound.gap += block_gap(program.blocks[k], program.blocks[k].slack(point.x), point.Z[k]);
  }
  return bound;
}

bool proves_infeasible(const Program& program, const Point& point,
                       std::vector<int>& unbounded_columns) {
  VectorXd error = VectorXd::Zero(program.variables());
  const VectorXd c = dual_gradient(program, point, error);
  double value = point.lambda.dot(program.rows.slack(point.x));
  for (size_t k = 0; k < program.blocks.size(); ++k) {
    value += program.blocks[k].slack(point.x).cwiseProduct(point.Z[k]).sum();
  }
  if (value >= 0.0) return false;
  // At every feasible u:  0 <= lambda'*slack(u) + Z.slack(u) = value + c'*(x - u).
  return value + gain_over_box(program, point.x, c, error, unbounded_columns) < 0.0;
}

}  // namespace veridyn::cone
