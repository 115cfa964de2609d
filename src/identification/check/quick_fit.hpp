#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "identification/check/check_thresholds.hpp"
#include "veridyn/identification/base_parameters.hpp"
#include "veridyn/model/model.hpp"
#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {

/// Sums over the rows of a recording from which its fit follows for any linear map of its torques.
struct RegressorMoments {
  std::vector<std::vector<MatrixXd>> products;  ///< for each fold and joint: products of the base columns and all torques
  std::vector<std::vector<int>> columns;        ///< indices of the base parameters of every joint
  MatrixXd power;   ///< (n x base) sum of the power that friction takes from each joint
  VectorXd speed2;  ///< squared speed of each joint
};

/// Properties of a recording that do not change under the tested transformations.
struct RecordedFacts {
  double rate = 0.0;    ///< [Hz]
  double period = 0.0;  ///< [s] period of the motion; 0: none
  VectorXd noise2;      ///< (n) share of each joint's squared torque that is white noise
};
RecordedFacts facts_of(const Recording& recording, const PreprocessingOptions& options);

/// Result of one short identification; errors refer to held-out rows.
struct QuickFit {
  VectorXd shares;  ///< unexplained share of each joint's squared torque
  MatrixXd folds;   ///< (joints x folds) these shares in each fold
  /// Sum over the joints of log(share), plus contradictions.
  double misfit = 0.0;
  double contradictions = 0.0;  ///< the part of the misfit from those costs, see contradiction_cost()
  VectorXd fitted;                 ///< (n) unexplained share in the fit to all rows, none of them held out
  double fitted_misfit = 0.0;      ///< the misfit of that fit
  VectorXd values;                 ///< base parameters of that fit; empty if the recording allows none
  VectorXd friction;               ///< power lost to friction in each joint, relative to rms torque times rms speed
  VectorXd friction_significance;  ///< relative rise of each joint's rms misfit without friction
  /// (n) recorded torque relative to that of the file's values; 0 if these explain too little of it.
  VectorXd ratios;
  /// (n) factor of each torque that fits best, if only this one is scaled, and if all are, up to a common
  /// factor.
  VectorXd alone, together;
  VectorXd noise2;  ///< (n) share of each joint's squared torque that is white noise
  std::shared_ptr<const RegressorMoments> moments;  ///< sums of the fitted motion

  /// Relative error of the torque, root mean square over the joints; noise() is the same for white noise.
  double relative_error() const { return std::sqrt(shares.mean()); }
  double noise() const { return std::sqrt(noise2.mean()); }
  double fitted_relative_error() const { return std::sqrt(fitted.mean()); }  ///< of the fit to all rows
  /// True if the remaining error of a joint is close to its noise.
  bool is_near(Eigen::Index joint) const {
    return std::sqrt(shares[joint]) <= std::max(checking::kNearNoise * std::sqrt(noise2[joint]), checking::kExact);
  }
  bool is_near() const {
    for (Eigen::Index joint = 0; joint < shares.size(); ++joint) {
      if (!is_near(joint)) return false;
    }
    return true;
  }
};

/// Fits an arm with plain friction, rotor inertia and all parameters free to short recordings.
class QuickFitter {
 public:
  QuickFitter(const Model& arm, const PreprocessingOptions& options, const RecordedFacts& facts);

  /// Number of base parameters that the recording determines, their total number, and the condition number.
  std::tuple<int, int, double> rank_and_condition(const Recording& recording) const;

  /// @returns null if the recording has too few rows, or numbers that are not finite.
  std::shared_ptr<const RegressorMoments> moments(const Recording& recording) const;

  /// @param torques  (n x n) maps the recorded torques to those of the joints, row i for joint i.
  QuickFit fit(const std::shared_ptr<const RegressorMoments>& moments, const MatrixXd& torques) const;

  /// Misfit of given base parameters, without contradictions, as QuickFit::fitted_misfit.
  double misfit_of(const VectorXd& values, const RegressorMoments& moments, const MatrixXd& torques) const;

  /// (n) share of a spring's torque on each joint that no other parameter of the arm can represent, its
  /// offset excluded.
  VectorXd independent_spring_shares(const Recording& recording) const;

 private:
  double ratio(const MatrixXd& products, const std::vector<int>& columns) const;
  double contradiction_cost(const QuickFit& fit) const;
  void add_power(const MatrixXd& dq, RegressorMoments& out) const;

  Model given_, arm_;
  PreprocessingOptions options_;
  RecordedFacts facts_;
  std::vector<StandardParameter> parameters_;
  BaseParameters base_;
  MatrixXd known_;  // (base x 1 + effects) base parameters of the file's values, then those of each effect alone
  bool has_values_ = false;
};

}  // namespace veridyn
