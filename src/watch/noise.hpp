#pragma once

#include <deque>
#include <vector>

#include "watch/hypotheses.hpp"
#include "watch/step.hpp"

namespace veridyn::watching {

/// A step after the autoregression of its joint, over the standard deviation of the innovation; rows
/// of joints whose friction at rest is not known count less.
struct WhiteStep {
  double time = 0.0;
  VectorXd e;  ///< (n)
  MatrixXd X;  ///< (n x hypotheses)
};

/// What a quiet arm leaves unexplained: what is different today, and the colour of the rest.
class NoiseModel {
 public:
  NoiseModel(const Model& arm, const std::vector<Hypothesis>& hypotheses);

  /// From the quiet steps so far: the colour from all, what is different today from those of today.
  /// @param before  of other days, each with its own differences taken off already.
  void fit(const std::vector<Step>& before, const std::vector<Step>& today);

  /// True where the model adds up more, on some joint, than it ever did while quiet.
  bool novel(const Step& step) const;

  /// The next step in order of time.
  /// @param known  (hypotheses) sizes of what is known already.
  WhiteStep whiten(const Step& step, const VectorXd& known);

  const VectorXd& deviation() const { return deviation_; }  ///< (n) of an innovation
  const VectorXd& today() const { return today_; }          ///< (hypotheses)

  /// Root mean square of the measured torque while quiet, (n).
  const VectorXd& scale() const { return scale_; }

  /// What is left of a step's residual.
  VectorXd rest(const Step& step, const VectorXd& known) const;

 private:
  void fit_colour(const std::vector<const std::vector<Step>*>& quiet);
  double novelty(const Step& step, int joint) const;
  void fit_today(const std::vector<Step>& quiet);

  int n_;
  std::vector<int> daily_;  // hypotheses that differ from day to day
  std::vector<int> joint_of_;
  std::vector<double> speed_of_;  // at which each makes the torque of its prior; 1: at any
  MatrixXd ar_;             // (n x order)
  VectorXd deviation_, today_, scale_;
  MatrixXd envelope_;       // (n x parts) largest parts while quiet
  std::deque<Step> past_;  // before the next one, the latest first
};

}  // namespace veridyn::watching
