#pragma once

namespace veridyn {

/// Probability that |T| of Student's t distribution exceeds |t|. Source: Abramowitz and
/// Stegun 26.7.
double student_t_two_sided(double t, double degrees_of_freedom);

/// The t that |T| exceeds with this probability (0.05 for 95 % intervals).
double student_t_quantile(double two_sided_probability, double degrees_of_freedom);

/// Probability that Fisher's F with these degrees of freedom exceeds f. Source: Abramowitz and
/// Stegun 26.6.2.
double fisher_f_upper_tail(double f, double numerator, double denominator);

}  // namespace veridyn
