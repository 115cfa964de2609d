#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "identification/check/check_thresholds.hpp"
#include "veridyn/math/square_root_information.hpp"
#include "veridyn/model/model.hpp"
#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {

/// Result of one short identification; errors are those of rows that were held out.
struct QuickFit {
  VectorXd shares;  ///< by joint: unexplained share of its squared torque
  MatrixXd folds;   ///< (joints x folds) the same in each fold
  /// Sum over the joints of log(share), and what contradicts physics or the values of the file; the smaller the better.
  double misfit = 0.0;
  double contradictions = 0.0;  ///< of these, the latter
  VectorXd friction;               ///< by joint: power lost to friction, relative to rms torque times rms speed
  VectorXd friction_significance;  ///< by joint: relative rise of the rms misfit without friction
  /// By joint: recorded torque per torque of the file's values; 0 where they explain too little of it to tell.
  VectorXd ratios;

  VectorXd noise2;  ///< by joint: share of its squared torque that white noise has

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
  QuickFitter(const Model& arm, const PreprocessingOptions& options);

  int base_size() const { return static_cast<int>(base_columns_.size()); }

  /// Number of base parameters that the recording determines, of how many, and their condition number.
  std::tuple<int, int, double> determined(const Recording& recording) const;

  QuickFit fit(const Recording& recording) const;

  /// By joint: share of a spring's torque that neither gravity nor anything else of the arm can take over, its offset
  /// left aside.
  VectorXd springs_apart(const Recording& recording) const;

 private:
  struct Friction;

  std::vector<Friction> frictions() const;
  MatrixXd friction_power(const Recording& recording) const;
  double ratio(const SquareRootInformation& joint) const;
  VectorXd noise2(const Recording& recording) const;
  double contradictions(const QuickFit& fit) const;

  Model given_, arm_;
  PreprocessingOptions options_;
  std::vector<StandardParameter> parameters_;
  std::vector<std::string> names_;
  std::vector<std::string> base_columns_;
  bool has_values_ = false;
};

}  // namespace veridyn
