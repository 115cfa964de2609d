#include "veridyn/identification/stale_rows.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace veridyn {
namespace {

constexpr double kStep = 0.005;

// Two joints on waves, with velocities and efforts.
Recording waves(int rows) {
  Recording r;
  r.time = VectorXd::LinSpaced(rows, 1.0, 1.0 + kStep * (rows - 1));
  r.q = r.dq = r.tau = MatrixXd(rows, 2);
  for (int k = 0; k < rows; ++k) {
    for (int i = 0; i < 2; ++i) {
      const double w = 4.0 + i;
      r.q(k, i) = std::sin(w * r.time[k]);
      r.dq(k, i) = w * std::cos(w * r.time[k]);
      r.tau(k, i) = std::cos(3.0 * r.time[k]);
    }
  }
  return r;
}

void repeat(Recording& r, int from, int count) {
  for (int k = from; k < from + count; ++k) {
    for (MatrixXd* m : {&r.q, &r.dq, &r.tau}) m->row(k) = m->row(from - 1);
  }
}

TEST(StaleRows, AreFilledInOnTheCubicThroughTheirNeighbours) {
  const Recording truth = waves(400);
  Recording late = truth;
  repeat(late, 50, 1);
  repeat(late, 100, 7);
  const double before = (late.q - truth.q).cwiseAbs().maxCoeff();
  const RepairedRecording found = without_stale_rows(late);
  EXPECT_EQ(found.repaired, 8);
  // A cubic over h errs by at most max |q''''| h^4 / 384, a straight line by |tau''| h^2 / 8.
  const double h = 8 * kStep;
  EXPECT_LT((found.recording.q - truth.q).cwiseAbs().maxCoeff(),
            std::pow(5.0, 4) * std::pow(h, 4) / 384.0);
  EXPECT_LT((found.recording.tau - truth.tau).cwiseAbs().maxCoeff(), 9.0 * h * h / 8.0 + 1e-12);
  EXPECT_GT(before, 0.1);
  // Nothing else changed.
  EXPECT_EQ(found.recording.q.row(49), truth.q.row(49));
  EXPECT_EQ(found.recording.q.row(107), truth.q.row(107));
}

TEST(StaleRows, WithoutVelocitiesTheyLieOnAStraightLine) {
  Recording late = waves(100);
  late.dq.resize(0, 0);
  for (MatrixXd* m : {&late.q, &late.tau}) m->row(51) = m->row(50);
  const Eigen::RowVectorXd middle = 0.5 * (late.q.row(50) + late.q.row(52));
  EXPECT_TRUE(without_stale_rows(late).recording.q.row(51).isApprox(middle, 1e-14));
}

TEST(StaleRows, AnArmAtRestLongFreezesAndGapsStayAsTheyAre) {
  Recording r = waves(400);
  for (int k = 300; k < 400; ++k) {  // at rest until the end
    for (MatrixXd* m : {&r.q, &r.dq, &r.tau}) m->row(k) = m->row(299);
  }
  repeat(r, 100, 40);  // 0.2 s
  repeat(r, 200, 2);
  r.tau(202, 1) = std::numeric_limits<double>::quiet_NaN();
  const RepairedRecording found = without_stale_rows(r);
  EXPECT_EQ(found.repaired, 0);
  EXPECT_EQ(found.recording.q, r.q);
}

}  // namespace
}  // namespace veridyn
