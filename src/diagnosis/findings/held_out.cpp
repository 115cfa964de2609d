#include "diagnosis/findings/held_out.hpp"

#include <algorithm>
#include <cmath>

namespace veridyn {
namespace {

// Sum over joints of the squared error above the noise floor, which a better model could remove. A joint
// without torque has no relative error and is left out.
double removable(const VectorXd& error, const VectorXd& floor) {
  const VectorXd below =
      floor.size() == error.size() ? VectorXd(floor.cwiseAbs2()) : VectorXd::Zero(error.size());
  VectorXd above = (error.cwiseAbs2() - below).cwiseMax(0.0);
  for (double& share : above) share = std::isfinite(share) ? share : 0.0;
  return above.sum();
}

}  // namespace

double explained_share(const VectorXd& before, const VectorXd& after, const Identification& baseline) {
  return explained_share(before, after, baseline.test_error.relative, baseline.noise_floor);
}

double explained_share(const VectorXd& before, const VectorXd& after, const VectorXd& errors, const VectorXd& floor) {
  if (before.size() == 0 || after.size() == 0) return 0.0;
  const double all = removable(errors, floor);
  if (all <= 0.0) return 0.0;
  return std::clamp((removable(before, floor) - removable(after, floor)) / all, -1.0, 1.0);
}

}  // namespace veridyn
