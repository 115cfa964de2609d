#pragma once

#include <array>
#include <string>
#include <vector>

#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Fit of an arm to recordings as a function of one constant of its geometry: every evaluation fits
/// all parameters, on sparse samples that are read once.
class GeometryProfiler {
 public:
  GeometryProfiler(const Model& arm, const std::vector<std::string>& train,
                   const IdentificationOptions& options);

  double start() const { return start_; }  ///< criterion() of the unmodified arm
  int recordings() const { return static_cast<int>(folds_.size()); }

  /// Sum over joints of ln(mean square residual).
  double criterion(const Model& variant, const std::vector<int>& columns) const;

  /// The criterion of three variants without one part of the recordings each, (parts x 3).
  MatrixXd without_parts(const std::array<Model, 3>& variants,
                         const std::vector<int>& columns) const;

  /// Columns that are independent for this geometry.
  static std::vector<int> independent(const Model& variant);

 private:
  // Sparse samples of one recording, with what does not depend on geometry computed once.
  struct Fold {
    MatrixXd q, dq, ddq;
    MatrixXd tau;
    MatrixXd effects;  // columns of the model's effects, per unit of their axes
  };
  struct Own;
  struct Sums;
  struct Parts;

  void append(const Segment& s, Fold& fold) const;
  MatrixXd effects_along(const Segment& s) const;
  std::vector<Own> own_columns(const TorqueRegressor& batch, const std::vector<int>& columns,
                               int bodies, int joints) const;
  static void add(double sign, const Sums& from, Sums& to);
  static Sums total(const std::vector<Sums>& parts);
  Parts sums_of_parts(const Model& variant, const std::vector<int>& columns,
                      Eigen::Index parts) const;
  VectorXd mean_squares(const std::vector<Own>& own, const Sums& sums, Eigen::Index columns) const;
  VectorXd mean_squares(const Model& variant, const std::vector<int>& columns) const;

  const Model& arm_;
  std::vector<Fold> folds_;
  std::vector<VectorXd> acts_on_;  // per effect column: the coefficients of its axis
  VectorXd weights_;
  double start_ = 0.0;
};

}  // namespace veridyn
