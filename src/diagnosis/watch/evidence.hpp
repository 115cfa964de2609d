#pragma once

#include <deque>
#include <vector>

#include "diagnosis/watch/noise.hpp"
#include "diagnosis/watch/watch_numbers.hpp"

namespace veridyn::watching {

/// Recursive least squares with forgetting of every hypothesis by itself: A <- f A + x' x.
struct Memory {
  double seconds = 0.0;  ///< [s] time constant of the forgetting
  double forgetting = 0.0;
  VectorXd A, b;

  void clear() {
    A.setZero();
    b.setZero();
  }
  void add(const WhiteStep& step);
  /// Twice the log-likelihood ratio of each hypothesis, b^2 / A if its size b / A is possible.
  /// @param least, largest  (hypotheses) sizes.
  VectorXd statistics(const VectorXd& least, const VectorXd& largest) const;
};

/// The statistics of a quiet arm, and their thresholds.
class Quantiles {
 public:
  Quantiles(int hypotheses, int memories, const WatchNumbers& numbers);

  /// Learns from the mean statistics (hypotheses x memories) of a quiet time.
  void learn(const MatrixXd& mean, const std::vector<Memory>& memories, double quiet_seconds,
             double false_alarms_per_hour);

  /// (hypotheses) statistic beyond which memory m raises an alarm; infinite until enough is
  /// learned.
  const VectorXd& threshold(int memory) const { return threshold_[memory]; }
  /// Dispersion of the statistics relative to white innovations, the mean of all hypotheses over
  /// the middle memory; and its degrees of freedom.
  double dispersion() const { return dispersion_; }
  double freedom() const { return freedom_; }

 private:
  const WatchNumbers& numbers_;
  std::vector<VectorXd> threshold_;
  double dispersion_ = 1.0, freedom_ = 1.0;
};

/// Evidence of the steps since an alarm for one hypothesis.
struct Score {
  int hypothesis = 0;
  double gain = 0.0;    ///< twice the log-likelihood ratio to "nothing changed"
  double onset = 0.0;   ///< [s]
  std::vector<int> columns;  ///< the hypothesis' own, then its companions'
  MatrixXd A;                ///< information of their sizes
  VectorXd size;

  /// Standard deviation of the first size, for white innovations.
  double deviation() const;
};

/// An external push: torques of any size on any joint, from onset to end.
struct Push {
  double gain = 0.0, from = 0.0, to = 0.0;
  VectorXd torque;  ///< (n) mean
  std::optional<JointIndex> last_joint;  ///< the one nearest to the tool that it moves
};

/// The best onset of a hypothesis among the steps from `earliest` to `latest` [s].
/// @param least, largest  its size.
Score best_onset(const std::deque<WhiteStep>& steps, int hypothesis, double least, double largest,
                 double earliest, double latest);

/// The same with companions, where their gain exceeds the price: the centre of a load of that mass
/// lies within some centimetres of its frame's origin.
Score with_companions(const std::deque<WhiteStep>& steps, const Score& alone,
                      const std::vector<int>& companions, double price, const WatchNumbers& numbers);

/// Estimates the sizes again from steps later than the onset by `skipped` [s]: the step of the
/// change mixes both states, and the autoregression includes it.
Score reestimated(const std::deque<WhiteStep>& steps, const Score& score, double skipped,
                     const WatchNumbers& numbers);

/// The best push with its onset between `earliest` and `latest`, which ends `still` seconds before the last
/// step, or lasts until now (still = 0).
/// @param offset_of_joint  (n) hypothesis of each joint's torque offset.
/// @param price  gain required of each joint in each half second.
Push best_push(const std::deque<WhiteStep>& steps, const std::vector<int>& offset_of_joint,
               double earliest, double latest, double still, double price,
               const WatchNumbers& numbers);

}  // namespace veridyn::watching
