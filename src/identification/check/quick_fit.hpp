#pragma once

#include <string>
#include <utility>
#include <vector>

#include "identification/check/check_thresholds.hpp"
#include "veridyn/math/square_root_information.hpp"
#include "veridyn/model/model.hpp"
#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {

/// Result of one short identification.
struct QuickFit {
  double unexplained = 1.0;    ///< share of the weighted squares of the torques
  double misfit = 0.0;         ///< sum over the joints of log(share); a share below
                               ///< CheckThresholds::smallest_share counts as that
  std::vector<double> shares;  ///< by joint: unexplained share of its squared torque
  MatrixXd halves;             ///< joints x 2: the same over the first and the second half
  VectorXd friction;  ///< by joint: power lost to friction, relative to rms torque times rms speed
  /// By joint: relative rise of the rms misfit without friction, its significance.
  std::vector<double> friction_significance;
};

/// Fits an arm with plain friction and all parameters free to one short recording after the other.
class QuickFitter {
 public:
  QuickFitter(const Model& arm, const PreprocessingOptions& options, const CheckThresholds& limits);

  const std::vector<StandardParameter>& parameters() const { return parameters_; }
  int base_size() const { return static_cast<int>(base_columns_.size()); }

  /// Number of base parameters that the recording determines, and their condition number.
  std::pair<int, double> determined(const Recording& recording) const;

  /// @param factors  if not null, the factor of each joint's torques over parameters() is appended.
  QuickFit fit(const Recording& recording, std::vector<SquareRootInformation>* factors = nullptr) const;

 private:
  struct Friction;

  std::vector<Friction> frictions() const;
  MatrixXd friction_power(const Recording& recording) const;

  Model arm_;
  PreprocessingOptions options_;
  double smallest_share_;
  std::vector<StandardParameter> parameters_;
  std::vector<std::string> names_;
  std::vector<std::string> base_columns_;
};

}  // namespace veridyn
