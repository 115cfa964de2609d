#pragma once

#include <deque>
#include <vector>

#include "diagnosis/watch/hypotheses.hpp"
#include "diagnosis/watch/step.hpp"
#include "diagnosis/watch/watch_numbers.hpp"

namespace veridyn::watching {

/// A step whitened by the autoregression of its joints, divided by the standard deviation of the
/// innovation; rows of joints with undetermined friction at rest have less weight.
struct WhiteStep {
  double time = 0.0;
  VectorXd e;  ///< (n)
  MatrixXd X;  ///< (n x hypotheses)
};

/// Residual of a quiet arm: its differences from other days, and an autoregression of the rest.
class NoiseModel {
 public:
  NoiseModel(const Model& arm, const std::vector<Hypothesis>& hypotheses,
             const WatchNumbers& numbers);

  /// Fits the quiet steps so far: the autoregression to all, the day's differences to those of
  /// today.
  /// @param before  steps of other days, with their own differences subtracted.
  void fit(const std::vector<Step>& before, const std::vector<Step>& today);

  /// True if a torque component of the model exceeds, on some joint, its range while quiet.
  bool novel(const Step& step) const;

  /// Whitens the next step in order of time.
  /// @param known  (hypotheses) sizes of changes that are known already.
  WhiteStep whiten(const Step& step, const VectorXd& known);

  const VectorXd& deviation() const { return deviation_; }  ///< (n) of an innovation
  const VectorXd& daily_offsets() const { return today_; }          ///< (hypotheses)

  /// Root mean square of the measured torque while quiet, (n).
  const VectorXd& scale() const { return scale_; }

  /// Residual of a step after known changes.
  VectorXd rest(const Step& step, const VectorXd& known) const;

 private:
  void fit_autoregression(const std::vector<const std::vector<Step>*>& quiet);  ///< fits the autoregression
  double novelty(const Step& step, int joint) const;  ///< sum of the excesses of torque components over their ranges while quiet
  void fit_daily_offsets(const std::vector<Step>& quiet);

  const WatchNumbers& numbers_;
  int n_;
  std::vector<int> daily_;  // hypotheses that differ from day to day
  std::vector<int> joint_of_;
  // Speed at which each gives the torque of its prior; 1: independent of speed.
  std::vector<double> speed_of_;
  MatrixXd ar_;             // (n x order)
  VectorXd deviation_, today_, scale_;
  MatrixXd envelope_;       // (n x parts) largest parts while quiet
  std::deque<Step> past_;  // previous steps, the latest first
};

}  // namespace veridyn::watching
