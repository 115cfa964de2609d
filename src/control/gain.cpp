#include "veridyn/control/gain.hpp"

#include <algorithm>

#include "veridyn/math/require.hpp"

namespace veridyn {

Gain::Gain(std::initializer_list<double> of_each) : values_(static_cast<Eigen::Index>(of_each.size())) {
  std::copy(of_each.begin(), of_each.end(), values_.data());
}

VectorXd Gain::expand(Eigen::Index n, const char* what) const {
  require(values_.size() == 1 || values_.size() == n, what, ": found ", values_.size(),
          " numbers, expected one, or one for each of ", n, ".");
  require(values_.allFinite() && values_.minCoeff() >= 0.0, what,
          ": found a number that is below zero or not finite.");
  return values_.size() == n ? values_ : VectorXd::Constant(n, values_[0]);
}

}  // namespace veridyn
