#include "control/moving_average.hpp"

#include <algorithm>
#include <cassert>

#include "veridyn/math/require.hpp"

namespace veridyn {

MovingAverage::MovingAverage(int size, int window) {
  require(size > 0 && window > 0, "MovingAverage: found ", size, " entries and a window of ",
          window, ", expected at least one of each.");
  samples_ = MatrixXd::Zero(size, window);
  mean_ = VectorXd::Zero(size);
}

const VectorXd& MovingAverage::update(const VectorXd& sample) noexcept {
  assert(sample.size() == mean_.size());
  const Eigen::Index window = samples_.cols();
  samples_.col(seen_ % window) = sample;
  ++seen_;
  // Summed anew each time: a running sum would keep rounding errors and NaN for ever.
  const Eigen::Index used = std::min<Eigen::Index>(seen_, window);
  mean_.setZero();
  for (Eigen::Index k = 0; k < used; ++k) mean_ += samples_.col(k);
  mean_ /= static_cast<double>(used);
  return mean_;
}

}  // namespace veridyn
