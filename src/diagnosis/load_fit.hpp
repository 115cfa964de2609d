#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "veridyn/diagnosis/payload.hpp"
#include "veridyn/identification/compressed_recording.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Sums of squares over a set of rows of one joint, with columns A and right side b.
struct RowSquares {
  MatrixXd AA;
  VectorXd Ab;
  double bb = 0.0;
  double rows = 0.0;

  RowSquares& operator+=(const RowSquares& other);
};

/// Sums of squares of every joint over the same columns, for each cluster of rows (phases of a motion, parts
/// of the poses).
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

  InertialParameters phi() const;  ///< about the origin of the frame
};

/// Change of the weighted squares by a load with parameters phi,
///
///   phi' A phi - 2 b' phi + com' com / reach^2,
///
/// with all other columns fitted at the same time. Weights count independent samples, so that the last term
/// is a prior on the distance between load and frame; undetermined directions stay at zero.
class MassCost {
 public:
  MassCost(MatrixXd A, VectorXd b, double reach) : A_(std::move(A)), b_(std::move(b)), reach_(reach) {}

  const MatrixXd& A() const { return A_; }
  const VectorXd& b() const { return b_; }

  /// The best result of descents from many starting points, or of one from `near`. The centre stays within
  /// the reach along each axis.
  PlacedMass fit() const;
  PlacedMass fit(const PlacedMass& near) const;

  /// The best centre for this mass.
  PlacedMass with_mass(double mass, const PlacedMass& near) const;

  /// Masses on either side of the best load for which the cost stays below `cost`, up to kHeaviestLoad.
  std::pair<double, double> masses_below(double cost, const PlacedMass& best) const;

  /// Covariance of mass and centre.
  Eigen::Matrix4d covariance(const PlacedMass& at) const;
  /// True for each axis along which the torques determine the centre more closely than the reach does.
  std::array<bool, 3> determined_axes(const PlacedMass& at) const;
  bool at_bound(const PlacedMass& at) const;  ///< true: a coordinate of the centre is at the reach, or the mass at kHeaviestLoad

  /// Inertia about the centre that a point mass does not have, by least squares.
  Eigen::Matrix<double, 6, 1> inertia_beyond_point_mass(const PlacedMass& at) const;

 private:
  PlacedMass at(double mass, const Eigen::Vector3d& com) const;  ///< with its cost; does not optimise
  PlacedMass descend(PlacedMass from, bool mass_is_free) const;  ///< minimum of the cost that Levenberg and Marquardt find

  MatrixXd A_;
  VectorXd b_;
  double reach_;
};

/// Weighted least-squares cost as a function of the load's ten parameters (columns first .. first + 9), with the columns
/// `beside` eliminated.
/// @param rows  squares of every joint, with weights (n).
/// @param without  sums to subtract, or null.
/// @param reach  [m] bound of the centre.
MassCost load_cost(const std::vector<RowSquares>& rows, const std::vector<RowSquares>* without, const VectorXd& weights,
                   int first, const std::vector<int>& beside, double reach);

/// Coefficients of the columns `beside`, fitted with weights to the residual of a load on `first`.
VectorXd fitted_beside_load(const std::vector<RowSquares>& rows, const std::vector<RowSquares>* without, const VectorXd& weights,
                     int first, const std::vector<int>& beside, const InertialParameters& phi);

/// Squared residual of every joint with a load and these other columns.
VectorXd residual_squares(const std::vector<RowSquares>& rows, int first, const InertialParameters& phi,
                      const std::vector<int>& beside, const VectorXd& values);

/// Solves A x = b for A >= 0, where columns may be zero or equal.
MatrixXd solve_scaled(const MatrixXd& A, const MatrixXd& b);

}  // namespace veridyn
