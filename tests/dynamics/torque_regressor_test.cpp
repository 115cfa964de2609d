#include "veridyn/dynamics/torque_regressor.hpp"

#include <gtest/gtest.h>

#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

class BatchOnEverySampleArm : public OnSampleArm {};
INSTANTIATE_TEST_SUITE_P(Sample, BatchOnEverySampleArm, testing::ValuesIn(sample_arm_names()),
                         sample_arm_name);

constexpr double kRounding = 1e-13;  // relative to the largest entry; the order of the sums is the same

struct Samples {
  MatrixXd q, dq, ddq;
};

Samples samples(int rows, int joints) {
  Random random(71);
  const auto matrix = [&](double size) -> MatrixXd {
    return Eigen::Map<const MatrixXd>(random.vector(rows * joints, -size, size).data(), rows,
                                      joints);
  };
  return {matrix(3), matrix(2), matrix(5)};
}

// Numbers of rows around the widths of the vectors, so that every tail is met.
const std::vector<int> kRows = {1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 17, 33};

TEST_P(BatchOnEverySampleArm, ColumnsOfAJointBelongToTheBodiesThatItMoves) {
  const TorqueRegressor batch(arm());
  for (int i = 0; i < joints(); ++i) {
    std::vector<int> expected;
    for (size_t b = 0; b < arm().bodies().size(); ++b) {
      if (!arm().moves(arm().bodies()[b], {i})) continue;
      for (int c = 0; c < kBodyParameters; ++c)
        expected.push_back(static_cast<int>(b) * kBodyParameters + c);
    }
    EXPECT_EQ(batch.columns({i}), expected);
  }
}

TEST_P(BatchOnEverySampleArm, RegressorIsThatOfEachState) {
  const TorqueRegressor batch(arm());
  std::vector<MatrixXd> Y;
  for (const int rows : kRows) {
    const Samples s = samples(rows, joints());
    batch.evaluate(s.q, s.dq, s.ddq, Y);
    ASSERT_EQ(static_cast<int>(Y.size()), joints());
    for (int row = 0; row < rows; ++row) {
      const MatrixXd one = torque_regressor(arm(), VectorXd(s.q.row(row)), VectorXd(s.dq.row(row)),
                                            VectorXd(s.ddq.row(row)));
      MatrixXd all = MatrixXd::Zero(joints(), one.cols());
      for (int i = 0; i < joints(); ++i) {
        for (size_t c = 0; c < batch.columns({i}).size(); ++c)
          all(i, batch.columns({i})[c]) = Y[i](row, static_cast<int>(c));
      }
      EXPECT_TRUE(near(all, one, kRounding * (1 + one.cwiseAbs().maxCoeff())))
          << rows << " rows, row " << row;
    }
  }
}

TEST_P(BatchOnEverySampleArm, AGroupOfJointsHasTheSameColumnsAsTheWholeArm) {
  const TorqueRegressor batch(arm());
  for (const int rows : {5, 150}) {
    const Samples s = samples(rows, joints());
    std::vector<MatrixXd> all;
    batch.evaluate(s.q, s.dq, s.ddq, all);
    for (int first = 0; first < joints(); ++first) {
      for (int end = first + 1; end <= joints(); ++end) {
        std::vector<MatrixXd> some;
        batch.evaluate(s.q, s.dq, s.ddq, first, end, some);
        for (int i = first; i < end; ++i) EXPECT_EQ(some[i], all[i]) << "joint " << i << " of " << first << " to " << end;
      }
    }
  }
}

TEST_P(BatchOnEverySampleArm, TorquesAreThoseOfEachState) {
  const TorqueRegressor batch(arm());
  MatrixXd tau;
  for (const int rows : kRows) {
    const Samples s = samples(rows, joints());
    batch.torques(s.q, s.dq, s.ddq, phi(), tau);
    for (int row = 0; row < rows; ++row) {
      const VectorXd one = inverse_dynamics(arm(), VectorXd(s.q.row(row)), VectorXd(s.dq.row(row)),
                                            VectorXd(s.ddq.row(row)));
      EXPECT_TRUE(near(tau.row(row).transpose(), one, kRounding * (10 + one.norm())))
          << rows << " rows, row " << row;
    }
  }
}

// Central differences: their error is h^2 / 6 of the third derivative.
constexpr double kStep = 6e-6;
constexpr double kDifferenceError = 1e-7;

TEST_P(BatchOnEverySampleArm, GradientIsThatOfTheWeightedRegressor) {
  const TorqueRegressor batch(arm());
  const int n = joints();
  for (const int rows : {3, 8, 11}) {
    const Samples s = samples(rows, n);
    Random random(72);
    std::vector<MatrixXd> weights;
    for (int i = 0; i < n; ++i) {
      const auto columns = static_cast<int>(batch.columns({i}).size());
      const VectorXd w = random.vector(rows * columns, -1, 1);
      weights.emplace_back(Eigen::Map<const MatrixXd>(w.data(), rows, columns));
    }
    const auto value = [&](const Samples& at) -> VectorXd {
      std::vector<MatrixXd> Y;
      batch.evaluate(at.q, at.dq, at.ddq, Y);
      VectorXd f = VectorXd::Zero(rows);
      for (size_t i = 0; i < Y.size(); ++i) f += Y[i].cwiseProduct(weights[i]).rowwise().sum();
      return f;
    };
    MatrixXd slopes;
    batch.gradient(s.q, s.dq, s.ddq, weights, slopes);
    ASSERT_EQ(slopes.cols(), 3 * n);
    for (int d = 0; d < 3 * n; ++d) {
      Samples above = s;
      Samples below = s;
      MatrixXd Samples::*part = d < n ? &Samples::q : d < 2 * n ? &Samples::dq : &Samples::ddq;
      (above.*part).col(d % n).array() += kStep;
      (below.*part).col(d % n).array() -= kStep;
      const VectorXd expected = (value(above) - value(below)) / (2 * kStep);
      EXPECT_TRUE(near(slopes.col(d), expected, kDifferenceError * (1 + value(s).norm())))
          << "direction " << d;
    }
  }
}

TEST_P(BatchOnEverySampleArm, TorqueDerivativesMatchDifferencesOfTheTorques) {
  const TorqueRegressor batch(arm());
  const int n = joints();
  const Samples s = samples(9, n);
  MatrixXd slopes;
  batch.torque_derivatives(s.q, s.dq, s.ddq, phi(), slopes);
  ASSERT_EQ(slopes.cols(), 3 * n * n);
  MatrixXd high;
  MatrixXd low;
  for (int d = 0; d < 3 * n; ++d) {
    Samples above = s;
    Samples below = s;
    MatrixXd Samples::*part = d < n ? &Samples::q : d < 2 * n ? &Samples::dq : &Samples::ddq;
    (above.*part).col(d % n).array() += kStep;
    (below.*part).col(d % n).array() -= kStep;
    batch.torques(above.q, above.dq, above.ddq, phi(), high);
    batch.torques(below.q, below.dq, below.ddq, phi(), low);
    EXPECT_TRUE(near(slopes.middleCols(d * n, n), (high - low) / (2 * kStep),
                     kDifferenceError * (10 + high.norm())));
  }
}

// A block of rows within longer recordings, as a view.
TEST(TorqueRegressor, ReadsBlocksOfLargerMatrices) {
  const Model arm = elbow_6r();
  const TorqueRegressor batch(arm);
  const Samples s = samples(100, 6);
  std::vector<MatrixXd> whole;
  std::vector<MatrixXd> block;
  batch.evaluate(s.q, s.dq, s.ddq, whole);
  batch.evaluate(s.q.middleRows(31, 20), s.dq.middleRows(31, 20), s.ddq.middleRows(31, 20), block);
  for (int i = 0; i < 6; ++i) {
    EXPECT_TRUE(near(block[i], whole[i].middleRows(31, 20),
                     kRounding * (1 + whole[i].cwiseAbs().maxCoeff())));
  }
}

TEST(TorqueRegressor, WritesOnlyItsOwnColumns) {
  const TorqueRegressor batch(elbow_6r());
  for (const int rows : {20, 300}) {  // directly, and by blocks
    const Samples s = samples(rows, 6);
    std::vector<MatrixXd> expected;
    batch.evaluate(s.q, s.dq, s.ddq, expected);
    std::vector<MatrixXd> wide(6, MatrixXd::Constant(rows, 63, 7.0));
    batch.evaluate(s.q, s.dq, s.ddq, wide);
    for (int i = 0; i < 6; ++i) {
      const Eigen::Index own = expected[i].cols();
      EXPECT_EQ(wide[i].leftCols(own), expected[i]);
      EXPECT_TRUE((wide[i].rightCols(63 - own).array() == 7.0).all());
    }
  }
}

TEST(TorqueRegressor, AnEmptyBatchGivesNoRows) {
  const TorqueRegressor batch(elbow_6r());
  const MatrixXd none(0, 6);
  std::vector<MatrixXd> Y;
  MatrixXd tau;
  batch.evaluate(none, none, none, Y);
  batch.torques(none, none, none, VectorXd::Zero(60), tau);
  EXPECT_EQ(Y[0].rows(), 0);
  EXPECT_EQ(Y[0].cols(), 60);
  EXPECT_EQ(tau.rows(), 0);
}

TEST(TorqueRegressor, WrongSizesAreNamed) {
  const TorqueRegressor batch(elbow_6r());
  const MatrixXd right = MatrixXd::Zero(4, 6);
  const MatrixXd narrow = MatrixXd::Zero(4, 5);
  const MatrixXd shorter = MatrixXd::Zero(3, 6);
  std::vector<MatrixXd> Y;
  MatrixXd tau;
  EXPECT_THROW(batch.evaluate(right, narrow, right, Y), InvalidInput);
  EXPECT_THROW(batch.evaluate(right, right, shorter, Y), InvalidInput);
  EXPECT_THROW(batch.torques(right, right, right, VectorXd::Zero(59), tau), InvalidInput);
  EXPECT_THROW(batch.torque_derivatives(right, right, right, VectorXd::Zero(59), tau), InvalidInput);
  EXPECT_THROW(batch.gradient(right, right, right, {}, tau), InvalidInput);
}

}  // namespace
}  // namespace veridyn
