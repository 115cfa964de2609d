#include "math/student_t.hpp"

#include <cmath>

namespace veridyn {
namespace {

// Logarithm of the gamma function; thread-safe, unlike std::lgamma(), which stores the sign in a global variable.
double log_gamma(double x) {
  int sign = 0;
  return ::lgamma_r(x, &sign);
}

// Continued fraction of the regularised incomplete beta function by Lentz's method (Abramowitz and
// Stegun 26.5.8).
double incomplete_beta(double a, double b, double x) {
  if (x <= 0.0) return 0.0;
  if (x >= 1.0) return 1.0;
  if (x > (a + 1.0) / (a + b + 2.0)) return 1.0 - incomplete_beta(b, a, 1.0 - x);
  const double front = std::exp(log_gamma(a + b) - log_gamma(a) - log_gamma(b) +
                                a * std::log(x) + b * std::log1p(-x)) /
                       a;
  constexpr double kTiny = 1e-300;
  double f = 1.0;
  double c = 1.0;
  double d = 0.0;
  for (int i = 0; i < 500; ++i) {
    const int m = i / 2;
    double term = 1.0;
    if (i > 0) {
      term = i % 2 == 0 ? m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
                        : -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
    }
    d = 1.0 + term * d;
    d = 1.0 / (std::abs(d) < kTiny ? kTiny : d);
    c = 1.0 + term / (std::abs(c) < kTiny ? kTiny : c);
    f *= c * d;
    if (std::abs(c * d - 1.0) < 1e-14) break;
  }
  return front * (f - 1.0);
}

}  // namespace

double student_t_two_sided(double t, double degrees_of_freedom) {
  return incomplete_beta(0.5 * degrees_of_freedom, 0.5,
                         degrees_of_freedom / (degrees_of_freedom + t * t));
}

double fisher_f_upper_tail(double f, double numerator, double denominator) {
  if (f <= 0.0) return 1.0;
  return incomplete_beta(0.5 * denominator, 0.5 * numerator,
                         denominator / (denominator + numerator * f));
}

double student_t_quantile(double two_sided_probability, double degrees_of_freedom) {
  double low = 0.0;
  double high = 1.0;
  while (student_t_two_sided(high, degrees_of_freedom) > two_sided_probability && high < 1e300)
    high *= 2.0;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (student_t_two_sided(middle, degrees_of_freedom) > two_sided_probability ? low : high) = middle;
  }
  return high;
}

}  // namespace veridyn
