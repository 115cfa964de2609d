#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn::internal {

/// One observation: its residual r(x), divided by its standard deviation, and on request dr/dx for
/// each of its unknowns, row by row.
///
/// @param x  the unknowns of the observation, in its order.
/// @param J  null, or one pointer per unknown; null where a derivative is not needed.
using Residual = std::function<void(const double* const* x, double* r, double* const* J)>;

struct Observation {
  std::vector<int> unknowns;
  int size = 0;
  Residual residual;
  double loss = 0.0;   ///< Huber's: a residual norm beyond this counts linearly; 0: squares
  bool active = true;  ///< false: excluded
};

struct Minimum {
  bool converged = false;
  double cost = 0.0;  ///< half the sum of the losses
  int iterations = 0;
  std::string message;
};

/// Nonlinear least squares over blocks of unknowns. Local unknowns belong to one frame of a
/// recording: no observation has two of them, so that they are eliminated first (Schur complement),
/// and the shared system is small.
class LeastSquares {
 public:
  enum class Scope { kShared, kLocal };

  /// @returns the index of the block of unknowns, from 0.
  int add_unknown(const VectorXd& start, Scope scope = Scope::kShared);
  /// @returns the index of the observation, from 0.
  int add(Observation observation);

  /// Levenberg-Marquardt from the present values, which become those of the minimum; stops when the cost decreases by less than 1e-12 of itself.
  Minimum minimise(int threads = 1, int iterations = 60);

  const VectorXd& value(int unknown) const { return unknowns_[at(unknown)].x; }
  VectorXd& value(int unknown) { return unknowns_[at(unknown)].x; }
  const std::vector<Observation>& observations() const { return observations_; }
  std::vector<Observation>& observations() { return observations_; }

  /// The residual of one observation at the present values, in standard deviations.
  VectorXd residual(const Observation& observation) const;

  /// Number of shared unknowns, and the index of a block among them.
  int shared_size() const;
  int shared_offset(int unknown) const;

 private:
  friend class Information;
  struct Unknown {
    VectorXd x;
    Scope scope;
  };
  static std::size_t at(int k) { return static_cast<std::size_t>(k); }
  std::vector<Unknown> unknowns_;
  std::vector<Observation> observations_;
};

/// J' J of all active observations at the minimum, stored as a block arrow: shared unknowns
/// densely, local ones block by block.
class Information {
 public:
  /// Linearises the problem at its present values.
  explicit Information(const LeastSquares& problem);

  /// J' J of the shared unknowns alone, the local ones eliminated.
  const MatrixXd& shared() const { return reduced_; }

  /// Covariance, for residuals of variance one, of functions with these derivatives.
  /// @param shared  (functions x shared_size()).
  /// @param local   derivatives by local unknown, (functions x its size); others are zero.
  MatrixXd covariance(const MatrixXd& shared, const std::map<int, MatrixXd>& local = {}) const;

  /// Numbers of scalar residuals and unknowns of the active observations.
  int residuals() const { return residuals_; }
  int unknowns() const { return unknowns_; }

 private:
  struct Local {
    MatrixXd inverse;   // inverse of the diagonal block of one local block of unknowns
    MatrixXd coupling;  // (shared x size) block between shared and local unknowns
  };
  MatrixXd reduced_;
  MatrixXd inverse_;
  std::map<int, Local> local_;
  int residuals_ = 0;
  int unknowns_ = 0;
};

}  // namespace veridyn::internal
