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

/// Sums over the rows of a recording, which determine its fit with any linear map of its torques.
struct RegressorMoments {
  std::vector<std::vector<MatrixXd>> products;  ///< by fold and joint: of its base columns and of all torques with each other
  std::vector<std::vector<int>> columns;        ///< of every joint, among the base parameters
  MatrixXd power;   ///< (n x base) sum of the power that friction takes from each joint
  VectorXd speed2;  ///< by joint
};

/// Properties of a recording that its transformations leave as they are.
struct RecordedFacts {
  double period = 0.0;  ///< [s] 0: none
  VectorXd noise2;      ///< by joint: share of its squared torque that white noise has
};
RecordedFacts facts_of(const Recording& recording, const PreprocessingOptions& options);

/// Result of one short identification; errors are those of rows that were held out.
struct QuickFit {
  VectorXd shares;  ///< by joint: unexplained share of its squared torque
  MatrixXd folds;   ///< (joints x folds) the same in each fold
  /// Sum over the joints of log(share), and what contradicts physics or the values of the file; the smaller the better.
  double misfit = 0.0;
  double contradictions = 0.0;  ///< of these, the latter
  VectorXd friction;               ///< by joint: power lost to friction, relative to rms torque times rms speed
  VectorXd friction_significance;  ///< by joint: relative rise of the rms misfit without friction
  /// By joint: recorded torque per torque of the file's values; 0 where they explain too little of it.
  VectorXd ratios;
  /// By joint: factor of its torque that fits best, where only its own differs from one, and where all do, up to a common factor.
  VectorXd alone, together;
  VectorXd noise2;  ///< by joint: share of its squared torque that white noise has
  std::shared_ptr<const RegressorMoments> moments;  ///< of the motion that was fitted

  /// Relative error of the torque, root mean square over the joints; and that of white noise.
  double left() const { return std::sqrt(shares.mean()); }
  double noise() const { return std::sqrt(noise2.mean()); }
  /// True if what is left of a joint is near its noise.
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

/// Fits an arm with plain friction, rotor inertia and all parameters free to one short recording after the other.
class QuickFitter {
 public:
  QuickFitter(const Model& arm, const PreprocessingOptions& options, const RecordedFacts& facts);

  /// Number of base parameters that the recording determines, of how many, and their condition number.
  std::tuple<int, int, double> determined(const Recording& recording) const;

  /// @returns null where the recording holds too few rows, or no finite numbers.
  std::shared_ptr<const RegressorMoments> moments(const Recording& recording) const;

  /// @param torques  (n x n) torque of joint i = column i times those recorded.
  QuickFit fit(const std::shared_ptr<const RegressorMoments>& moments, const MatrixXd& torques) const;

  /// By joint: share of a spring's torque that neither gravity nor anything else of the arm can take over, its offset
  /// left aside.
  VectorXd springs_apart(const Recording& recording) const;

 private:
  double ratio(const MatrixXd& products, const std::vector<int>& columns) const;
  double contradictions(const QuickFit& fit) const;
  void add_power(const MatrixXd& dq, RegressorMoments& out) const;

  Model given_, arm_;
  PreprocessingOptions options_;
  RecordedFacts facts_;
  std::vector<StandardParameter> parameters_;
  BaseParameters base_;
  MatrixXd known_;  // (base x 1 + effects) parameters of the file's values, and of every effect alone
  bool has_values_ = false;
};

}  // namespace veridyn
