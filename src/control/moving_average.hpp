#pragma once

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Mean of the last `window` samples of each entry, or of all samples while there are fewer. The
/// thesis smooths joint velocities with ten (7.5). It lags by (window - 1) / 2 samples.
///
///   MovingAverage smooth(3);
///   every cycle: dq = smooth.update(dq_measured);
class MovingAverage {
 public:
  /// @throws InvalidInput  size or window below one.
  explicit MovingAverage(int size, int window = 10);

  const VectorXd& update(const VectorXd& sample) noexcept;
  void reset() noexcept { seen_ = 0; }
  const VectorXd& mean() const { return mean_; }

 private:
  MatrixXd samples_;  // (size x window), a ring
  VectorXd mean_;
  long seen_ = 0;
};

}  // namespace veridyn
