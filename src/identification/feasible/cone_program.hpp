#pragma once

// Private to feasible_least_squares: the problem in the form of the interior-point method.

#include <vector>

#include "veridyn/identification/feasible_least_squares.hpp"

namespace veridyn::cone {

using Matrix10 = Eigen::Matrix<double, 10, 10>;

/// One linear matrix inequality on ten neighbouring variables phi:  S = A(phi) - margin*1 >= 0,
/// where the upper triangle of A(phi), row by row, is map * phi. If log_det_weight > 0, the cost
/// has the term -log_det_weight * log det S and the inequality is strict by itself.
struct Block {
  int column = 0;
  Matrix10 map = Matrix10::Zero();
  bool is_pseudo_inertia = true;
  double margin = 0.0;
  double log_det_weight = 0.0;
  InertialVector prior =
      InertialVector::Zero();  ///< reference of the log-det term, and initial value

  Eigen::Matrix4d slack(const VectorXd& x) const;
  Eigen::Matrix4d apply(const VectorXd& direction) const;  ///< A(direction)
  InertialVector adjoint(const Eigen::Matrix4d& Z) const;
};

/// The block of one body; the map of the given condition (not kNone).
Block make_block(int column, PhysicalCondition condition);

/// Nonzero entries of the rows of G.
struct SparseRows {
  std::vector<int> start{0};
  std::vector<int> column;
  std::vector<double> value;
  VectorXd bound;

  int size() const { return static_cast<int>(bound.size()); }
  double dot(int row, const VectorXd& x) const;  ///< product of a row of G and x
  VectorXd slack(const VectorXd& x) const;                              ///< bound - G*x
  void add_transposed(const VectorXd& lambda, VectorXd& result) const;  ///< result += G'*lambda
};

SparseRows sparse_rows(const MatrixXd& G, const VectorXd& h);

/// Interval of each variable over all feasible points; infinite where the constraints imply none.
struct Box {
  VectorXd lower;
  VectorXd upper;
  VectorXd trusted;  ///< a variable without an interval is assumed to lie within 2*|x_j| + trusted_j

  /// Plausible change of variable j: the width of its interval, or less where the data limit it.
  double reach(int j) const;
};

/// minimise ||R*x - z||^2 + linear'*x + constant - sum of the blocks' log-det terms.
struct Program {
  MatrixXd R;
  VectorXd z;
  VectorXd linear;
  double constant = 0.0;
  SparseRows rows;
  std::vector<Block> blocks;
  Box box;

  int variables() const { return static_cast<int>(R.cols()); }
};

/// Bounds that follow from the rows by interval arithmetic, and from the positive semidefinite
/// blocks.
Box implied_box(const SparseRows& rows, const std::vector<Block>& blocks, int variables);

/// ||R*x - z||^2 + linear'*x + constant - log-det terms; infinity where a log-det block is not
/// positive definite.
double cost(const Program& program, const VectorXd& x);
double cost(const Program& program, const VectorXd& x, const VectorXd& residual);  ///< R*x - z

/// True if all constraints hold up to rounding, though perhaps not strictly.
bool met_to_rounding(const Program& program, const VectorXd& x);

/// The symmetric Z with pseudo_inertia_adjoint(Z) = phi.
Eigen::Matrix4d pseudo_inertia_from_adjoint(const InertialVector& phi);

/// A point of the primal-dual space; multipliers positive (definite).
struct Point {
  VectorXd x;
  VectorXd lambda;
  std::vector<Eigen::Matrix4d> Z;
};

/// cost - lower bound, from weak duality (Lagrangian at the residual and the multipliers of the
/// point).
struct Bound {
  double gap = 0.0;
  std::vector<int> unbounded_columns;  ///< columns for which `trusted` was used
};

/// Largest gain over the box against a linear cost:  max over u of  c'*(x - u), with |error| added
/// to each |c_j|. Adds columns that needed `trusted`.
double gain_over_box(const Program& program, const VectorXd& x, const VectorXd& c,
                     const VectorXd& error, std::vector<int>& unbounded_columns);

/// @param residual  R*x - z at the point.
Bound duality_gap(const Program& program, const Point& point, const VectorXd& residual);

/// True if the multipliers prove infeasibility:  lambda'*h - margins < min over the box of
/// (G'*lambda - adjoint(Z))'*u. Fills the columns that needed `trusted`.
bool proves_infeasible(const Program& program, const Point& point,
                       std::vector<int>& unbounded_columns);

}  // namespace veridyn::cone
