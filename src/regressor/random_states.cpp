#include "regressor/random_states.hpp"

#include <algorithm>

#include "math/random_numbers.hpp"
#include "kinematics/motion_limits.hpp"

namespace veridyn {

MotionSamples random_states(const Model& arm, int count, unsigned seed,
                            const std::vector<std::string>& still) {
  RandomNumbers random(seed);
  const MotionLimits limits = motion_limits(arm);
  const int n = arm.joints();
  MotionSamples out{VectorXd::LinSpaced(count, 0.0, 1.0), MatrixXd(count, n), MatrixXd(count, n),
                    MatrixXd(count, n)};
  for (int k = 0; k < count; ++k) {
    for (int i = 0; i < n; ++i) {
      out.q(k, i) = random.uniform(limits.lower[i], limits.upper[i]);
      out.dq(k, i) = limits.velocity[i] * random.uniform(-1.0, 1.0);
      out.ddq(k, i) = 5.0 * limits.velocity[i] * random.uniform(-1.0, 1.0);
    }
  }
  for (int i = 0; i < n; ++i) {
    const std::string& name = arm.coordinates()[static_cast<size_t>(i)].name;
    if (std::find(still.begin(), still.end(), name) == still.end()) continue;
    out.q.col(i).setConstant(0.5 * (limits.lower[i] + limits.upper[i]));
    out.dq.col(i).setZero();
    out.ddq.col(i).setZero();
  }
  return out;
}

int state_count(int columns, int joints) {
  return 20 + 2 * columns / std::max(1, joints);
}

}  // namespace veridyn
