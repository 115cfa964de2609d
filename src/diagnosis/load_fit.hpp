#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "veridyn/diagnosis/payload.hpp"
#include "veridyn/identification/compressed_recording.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Sums of squares of one set of rows of a joint, over columns A and right side b.
struct RowSquares {
  MatrixXd AA;
  VectorXd Ab;
  double bb = 0.0;
  double rows = 0.0;

  RowSquares& operator+=(const RowSquares& other);
};

/// Squares of every joint over the same columns, in clusters of rows (phases of a motion, parts of poses).
class LoadRows {
 public:
  LoadRows(const std::vector<CompressedRecording>& recordings, const std::vector<std::string>& columns, int joints);

  int clusters() const { return static_cast<int>(clusters_.size()); }
  int joints() const { return static_cast<int>(total_.size()); }
  const std::vector<RowSquares>& cluster(int k) const { return clusters_[k]; }
  const std::vector<RowSquares>& total() const { return total_; }

 private:
  std::vector<std::vector<RowSquares>> clusters_;  // [cluster][joint]
  std::vector<RowSquares> total_;
};

/// A point mass of either sign on a frame.
struct PlacedMass {
  double mass = 0.0;               ///< [kg]
  Eigen::Vector3d com{0, 0, 0};    ///< [m]
  double cost = 0.0;               ///< change of the weighted squares, with the prior of the centre

  InertialParameters phi() const;
};

/// phi' A phi - 2 b' phi + com' com / reach^2 over the parameters of a load: the change of the weighted
/// squares with the other columns fitted beside it. Weights are in units of independent samples, so that the
/// last term is a prior on the distance of a load from its frame; undetermined directions stay at zero.
class MassCost {
 public:
  MassCost(MatrixXd A, VectorXd b, double reach) : A_(std::move(A)), b_(std::move(b)), reach_(reach) {}

  const MatrixXd& A() const { return A_; }
  const VectorXd& b() const { return b_; }

  /// The best of descents from many places, or next to `near`. The centre stays within the reach along each axis.
  PlacedMass fit() const;
  PlacedMass fit(const PlacedMass& near) const;

  /// The best centre for a given mass.
  PlacedMass with_mass(double mass, const PlacedMass& near) const;

  /// Masses for which the cost stays below `cost`, around those of the best load; as far as kHeaviestLoad.
  std::pair<double, double> masses_below(double cost, const PlacedMass& best) const;

  /// Covariance of mass and centre.
  Eigen::Matrix4d covariance(const PlacedMass& at) const;
  /// True for each axis along which torques determine the place better than the reach does.
  std::array<bool, 3> seen(const PlacedMass& at) const;
  bool at_bound(const PlacedMass& at) const;

  /// Inertia about the centre beyond the point mass; least squares.
  Eigen::Matrix<double, 6, 1> extent(const PlacedMass& at) const;

 private:
  PlacedMass at(double mass, const Eigen::Vector3d& com) const;
  PlacedMass descend(PlacedMass from, bool mass_is_free) const;

  MatrixXd A_;
  VectorXd b_;
  double reach_;
};

/// The cost of the load of ten columns from `first` on, other columns of the set fitted beside it.
/// @param rows  [joint]; weights (n).
MassCost load_cost(const std::vector<RowSquares>& rows, const std::vector<RowSquares>* without, const VectorXd& weights,
                   int first, const std::vector<int>& beside, double reach);

/// Coefficients of the columns `beside`, fitted with weights to the residual of a load on `first`.
VectorXd fitted_beside_load(const std::vector<RowSquares>& rows, const std::vector<RowSquares>* without, const VectorXd& weights,
                     int first, const std::vector<int>& beside, const InertialParameters& phi);

/// Squared residual per joint of a load and these other columns.
VectorXd residual_squares(const std::vector<RowSquares>& rows, int first, const InertialParameters& phi,
                      const std::vector<int>& beside, const VectorXd& values);

/// Solves A x = b for A >= 0 whose columns may be zero or equal.
MatrixXd solve_scaled(const MatrixXd& A, const MatrixXd& b);

}  // namespace veridyn
