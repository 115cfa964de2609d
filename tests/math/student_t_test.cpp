#include "math/student_t.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace veridyn {
namespace {

// Abramowitz and Stegun, table 26.10, and the same to more digits by R's qt(1 - p / 2, nu).
TEST(StudentsT, AgreesWithTheTables) {
  struct Entry {
    double probability, freedom, t;
  };
  for (const Entry& e : {Entry{0.05, 1, 12.7062047364},
                         {0.05, 2, 4.3026527297},
                         {0.05, 5, 2.5705818356},
                         {0.05, 10, 2.2281388520},
                         {0.05, 30, 2.0422724563},
                         {0.05, 120, 1.9799304051},
                         {0.01, 1, 63.6567411629},
                         {0.01, 2, 9.9248432009},
                         {0.01, 5, 4.0321429836},
                         {0.01, 10, 3.1692726726},
                         {0.01, 30, 2.7499956536},
                         {0.5, 1, 1.0},
                         {0.5, 7, 0.7111417781},
                         {0.001, 8, 5.0413054334}}) {
    EXPECT_NEAR(student_t_quantile(e.probability, e.freedom), e.t, 2e-9 * e.t)
        << e.probability << ", " << e.freedom;
    EXPECT_NEAR(student_t_two_sided(e.t, e.freedom), e.probability, 1e-9 * e.probability);
    EXPECT_DOUBLE_EQ(student_t_two_sided(-e.t, e.freedom), student_t_two_sided(e.t, e.freedom));
  }
}

// One to four degrees of freedom have closed forms.
TEST(StudentsT, AgreesWithItsClosedForms) {
  for (double t = 0.0; t < 40.0; t = 1.3 * t + 0.01) {
    EXPECT_NEAR(student_t_two_sided(t, 1), 1.0 - 2.0 / M_PI * std::atan(t), 1e-13);
    EXPECT_NEAR(student_t_two_sided(t, 2), 1.0 - t / std::sqrt(2.0 + t * t), 1e-13);
    const double u = t / std::sqrt(3.0);
    EXPECT_NEAR(student_t_two_sided(t, 3), 1.0 - 2.0 / M_PI * (std::atan(u) + u / (1.0 + u * u)),
                1e-13);
    const double s = t / std::sqrt(4.0 + t * t);
    EXPECT_NEAR(student_t_two_sided(t, 4), 1.0 - s * (1.5 - 0.5 * s * s), 1e-13);
  }
}

TEST(StudentsT, BecomesNormalWithManyDegreesOfFreedom) {
  // The first correction is t (t^2 + 1) phi(t) / (2 nu), below 0.3 / nu.
  for (const double t : {0.1, 0.5, 1.0, 1.96, 3.0, 4.0}) {
    EXPECT_NEAR(student_t_two_sided(t, 1e7), std::erfc(t / std::sqrt(2.0)), 1e-7);
  }
  EXPECT_NEAR(student_t_quantile(0.05, 1e7), 1.959963985, 1e-6);
}

// Small probabilities keep their digits: for nu = 2 the tail is 1 / t^2 (1 - 3 / t^2 ...).
TEST(StudentsT, IsAccurateInTheTails) {
  for (const double t : {1e3, 1e5, 1e8})
    EXPECT_NEAR(student_t_two_sided(t, 2) * t * t, 1.0, 3.1 / (t * t) + 1e-12);
}

TEST(StudentsT, QuantileAndProbabilityAreInverse) {
  for (const double freedom : {1.0, 2.5, 7.0, 60.0, 5000.0}) {
    for (const double p : {1e-9, 1e-4, 0.05, 0.3, 0.9, 0.999}) {
      EXPECT_NEAR(student_t_two_sided(student_t_quantile(p, freedom), freedom), p, 1e-9 * p)
          << p << ", " << freedom;
    }
  }
}

}  // namespace
}  // namespace veridyn
