#include "deviations.hpp"

#include <algorithm>
#include <cmath>

#include "veridyn/math/median.hpp"
#include "veridyn/math/student_t.hpp"

namespace veridyn::internal {
namespace {

constexpr double kNormalMedian = 0.6744898;   // median of |z|
constexpr double kLengthMedian = 1.538172;    // median of the length of a normal 3-vector
constexpr double kUncorrelated = 0.05;        // correlations below this end the sum
constexpr std::size_t kLongestLag = 200;
constexpr double kUpperTail = 1.6448536;      // quantile of the normal distribution, 5 %

}  // namespace

double robust_deviation(std::vector<double> values) {
  for (double& v : values) v = std::abs(v);
  return median(std::move(values)) / kNormalMedian;
}

double robust_deviation_of_lengths(std::vector<double> lengths) {
  return median(std::move(lengths)) / kLengthMedian;
}

double error_radius(const MatrixRef& covariance, double degrees_of_freedom) {
  const double trace = covariance.trace();
  if (!(trace > 0.0)) return 0.0;
  const double squares = (covariance * covariance).trace();
  const double nu = trace * trace / squares;
  // Wilson and Hilferty's quantile of chi-square.
  const double spread = 2.0 / (9.0 * nu);
  const double chi2 = nu * std::pow(1.0 - spread + kUpperTail * std::sqrt(spread), 3.0);
  // Few degrees of freedom widen it by the ratio of the t quantiles.
  const double widened =
      student_t_quantile(0.05, std::max(1.0, degrees_of_freedom)) / student_t_quantile(0.05, 1e6);
  return widened * std::sqrt(squares / trace * chi2);
}

double half_width(double variance, double degrees_of_freedom) {
  return student_t_quantile(0.05, std::max(1.0, degrees_of_freedom)) *
         std::sqrt(std::max(0.0, variance));
}

double correlation_factor(const std::vector<std::vector<double>>& series) {
  double factor = 1.0;
  for (std::size_t lag = 1; lag <= kLongestLag; ++lag) {
    double product = 0.0;
    double square = 0.0;
    for (const std::vector<double>& values : series) {
      for (std::size_t k = lag; k < values.size(); ++k) {
        const double p = values[k] * values[k - lag];
        if (!std::isfinite(p)) continue;
        product += p;
        square += 0.5 * (values[k] * values[k] + values[k - lag] * values[k - lag]);
      }
    }
    const double correlation = square > 0.0 ? product / square : 0.0;
    if (correlation < kUncorrelated) break;
    factor += 2.0 * correlation;
  }
  return factor;
}

}  // namespace veridyn::internal
