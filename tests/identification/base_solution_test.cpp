#include "identification/base_solution.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "support/near.hpp"
#include "support/random.hpp"

namespace veridyn {
namespace {

using Names = std::vector<std::string>;

// Rows of two joints over four parameters of which the last is twice the third; each joint sees
// three of them.
struct Data {
  std::vector<MatrixXd> A;  ///< [block * 2 + joint] (rows x 4), whole
  std::vector<VectorXd> b;
  std::vector<CompressedRecording> recordings;
};

const Names& names() {
  static const Names kNames{"p0", "p1", "p2", "p3"};
  return kNames;
}

BaseParameters base() {
  BaseParameters out;
  out.independent = {0, 1, 2};
  out.K = (MatrixXd(3, 4) << 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 2).finished();
  out.names = {"p0", "p1", "p2"};
  return out;
}

// Two recordings of `blocks` blocks each; the noise has the given size, and what the second joint
// says is `second` times as large.
Data data(int blocks, double noise, unsigned seed, double second = 1.0) {
  Random random(seed);
  Data d;
  for (int r = 0; r < 2; ++r) {
    CompressedRecording recording;
    recording.joints.resize(2);
    for (int k = 0; k < blocks; ++k) {
      recording.blocks.emplace_back();
      for (int i = 0; i < 2; ++i) {
        const int rows = 40 + 10 * k;
        MatrixXd A = MatrixXd::Zero(rows, 4);
        A.col(i) = random.vector(rows, -1, 1);
        A.col(2) = random.vector(rows, -3, 3);
        A.col(3) = 2.0 * A.col(2);
        if (i == 1) A *= second;
        const VectorXd b =
            A * Eigen::Vector4d(1.0, -2.0, 0.5, 0.0) +
            (i == 1 ? second : 1.0) * noise * random.vector(rows, -1, 1);
        SquareRootInformation f(Names{names()[i], "p2", "p3"});
        MatrixXd mine(rows, 3);
        mine << A.col(i), A.rightCols(2);
        f.absorb(mine, b);
        recording.blocks.back().push_back(f);
        recording.rows += rows;
        d.A.push_back(A);
        d.b.push_back(b);
      }
    }
    d.recordings.push_back(recording);
  }
  return d;
}

// All rows but those of one block, weighted, over the independent columns.
struct Stacked {
  MatrixXd A;
  VectorXd b;
  VectorXd solution() const { return Eigen::ColPivHouseholderQR<MatrixXd>(A).solve(b); }
};

Stacked stacked(const Data& d, const VectorXd& weights, int without = -1) {
  Stacked out{MatrixXd(0, 3), VectorXd(0)};
  for (size_t k = 0; k < d.A.size(); ++k) {
    if (static_cast<int>(k) / 2 == without) continue;
    const double w = weights[static_cast<Eigen::Index>(k % 2)];
    const Eigen::Index n = out.A.rows();
    out.A.conservativeResize(n + d.A[k].rows(), 3);
    out.b.conservativeResize(n + d.A[k].rows());
    out.A.bottomRows(d.A[k].rows()) = w * d.A[k].leftCols(3);
    out.b.tail(d.A[k].rows()) = w * d.b[k];
  }
  return out;
}

TEST(TheBaseSolution, EqualsLeastSquaresOfTheStackedWeightedRows) {
  const Data d = data(5, 0.3, 1);
  for (const Eigen::Vector2d& weights : {Eigen::Vector2d(1, 1), Eigen::Vector2d(0.2, 7)}) {
    const BaseSolution s = solve_base(d.recordings, weights, base(), names());
    const Stacked direct = stacked(d, weights);
    const VectorXd x = direct.solution();
    const double residual2 = (direct.A * x - direct.b).squaredNorm();
    EXPECT_TRUE(near(s.beta, x, 1e-12));
    EXPECT_NEAR(s.residual2, residual2, 1e-12 * direct.b.squaredNorm());
    const auto rows = static_cast<double>(direct.A.rows());
    const MatrixXd covariance =
        (direct.A.transpose() * direct.A).inverse() * residual2 / (rows - 3.0);
    EXPECT_TRUE(near(s.white_std, covariance.diagonal().cwiseSqrt(), 1e-12));
    const VectorXd sv = Eigen::JacobiSVD<MatrixXd>(direct.A).singularValues();
    EXPECT_NEAR(s.condition_number, sv[0] / sv[2], 1e-10 * s.condition_number);
    MatrixXd scaled = direct.A;
    scaled.colwise().normalize();
    const VectorXd sv2 = Eigen::JacobiSVD<MatrixXd>(scaled).singularValues();
    EXPECT_NEAR(s.condition_number_scaled, sv2[0] / sv2[2], 1e-10 * s.condition_number_scaled);
    EXPECT_LE(s.effective_samples, rows);
    EXPECT_GT(s.effective_samples, 0.0);
  }
}

// (g - 1) / g * sum of squares about their mean of the solutions without one block each.
TEST(TheBaseSolution, HasTheStandardDeviationOfTheJackknife) {
  const Data d = data(5, 0.3, 2);
  const Eigen::Vector2d weights(0.5, 2.0);
  const int g = 10;
  MatrixXd left_out(3, g);
  for (int k = 0; k < g; ++k) left_out.col(k) = stacked(d, weights, k).solution();
  const VectorXd mean = left_out.rowwise().mean();
  const VectorXd expected =
      ((left_out.colwise() - mean).rowwise().squaredNorm() * (g - 1.0) / g).cwiseSqrt();
  const BaseSolution s = solve_base(d.recordings, weights, base(), names());
  EXPECT_TRUE(near(s.std, expected, 1e-11));
  // ... and the covariances that go with it.
  const MatrixXd about = left_out.colwise() - mean;
  EXPECT_TRUE(
      near(s.scatter * s.scatter.transpose(), about * about.transpose() * ((g - 1.0) / g), 1e-11));
  EXPECT_EQ(s.clusters, g);
}

// With independent noise both standard deviations mean the same: over many draws their squares have
// one mean, and the solutions scatter as they say.
TEST(TheBaseSolution, StandardDeviationsCoverTheErrorsOverSeeds) {
  const int draws = 200;
  Eigen::Vector3d jackknife2 = Eigen::Vector3d::Zero();
  Eigen::Vector3d white2 = Eigen::Vector3d::Zero();
  Eigen::Vector3d error2 = Eigen::Vector3d::Zero();
  for (int k = 0; k < draws; ++k) {
    const BaseSolution s =
        solve_base(data(5, 0.3, 100 + k).recordings, Eigen::Vector2d(1, 1), base(), names());
    jackknife2 += s.std.cwiseAbs2() / draws;
    white2 += s.white_std.cwiseAbs2() / draws;
    error2 += (s.beta - Eigen::Vector3d(1.0, -2.0, 0.5)).cwiseAbs2() / draws;
  }
  // A mean of 200 squares is known to sqrt(2 / 200) = 10 %; three of these.
  for (int j = 0; j < 3; ++j) {
    EXPECT_NEAR(error2[j] / white2[j], 1.0, 0.3);
    EXPECT_NEAR(jackknife2[j] / white2[j], 1.0, 0.3);
  }
}

TEST(TheBaseSolution, HasNoStandardDeviationFromTwoBlocks) {
  Data d = data(2, 0.3, 3);
  d.recordings.pop_back();
  const BaseSolution s = solve_base(d.recordings, Eigen::Vector2d(1, 1), base(), names());
  EXPECT_TRUE(s.std.array().isNaN().all());
  EXPECT_EQ(s.scatter.cols(), 0);
  EXPECT_TRUE(s.beta.allFinite());
}

TEST(TheWeightedTotal, HasTheSumOfSquaresOfAllWeightedRows) {
  const Data d = data(4, 0.3, 4);
  const Eigen::Vector2d weights(3.0, 0.25);
  const SquareRootInformation total = weighted_total(joint_totals(d.recordings), weights, names());
  ASSERT_EQ(total.columns(), names());
  Random random(5);
  for (int k = 0; k < 5; ++k) {
    const VectorXd x = random.vector(4, -2, 2);
    double direct = 0.0;
    for (size_t p = 0; p < d.A.size(); ++p) {
      direct += (weights[static_cast<Eigen::Index>(p % 2)] * (d.A[p] * x - d.b[p])).squaredNorm();
    }
    EXPECT_NEAR(total.residual2(x), direct, 1e-11 * direct);
  }
}

TEST(RangeWeights, AreTheInverseTorqueRangeOverAllRecordings) {
  Data d = data(3, 0.3, 6);
  d.recordings[0].joints[0] = {-1.0, 2.0, 0, 0, 0};
  d.recordings[1].joints[0] = {0.0, 4.0, 0, 0, 0};
  d.recordings[0].joints[1] = {0.5, 0.5, 0, 0, 0};
  d.recordings[1].joints[1] = {0.5, 0.5, 0, 0, 0};
  EXPECT_TRUE(near(range_weights(d.recordings), Eigen::Vector2d(0.2, 1.0), 1e-15));
}

// 1 / standard deviation of the residuals of both joints for these parameters.
VectorXd deviations_turned_round(const Data& d, const VectorXd& x) {
  VectorXd sum = VectorXd::Zero(2);
  VectorXd rows = VectorXd::Zero(2);
  for (size_t k = 0; k < d.A.size(); ++k) {
    sum[static_cast<Eigen::Index>(k % 2)] += (d.A[k].leftCols(3) * x - d.b[k]).squaredNorm();
    rows[static_cast<Eigen::Index>(k % 2)] += static_cast<double>(d.b[k].size());
  }
  return (rows.array() / sum.array()).sqrt();
}

TEST(ResidualWeights, AreTheInverseDeviationsOfTheFitWithTheFirstWeights) {
  const Data d = data(3, 0.3, 7, 0.01);
  for (const Eigen::Vector2d& start : {Eigen::Vector2d(1, 1), Eigen::Vector2d(1, 1000)}) {
    const VectorXd direct = deviations_turned_round(d, stacked(d, start).solution());
    EXPECT_TRUE(near(residual_weights(joint_totals(d.recordings), start, base(), names()), direct, 1e-9));
  }
}

// From the range of the torques; from equal weights the small joint's residual is that of a fit which
// ignores it.
TEST(ResidualWeights, OfAJointWithSmallTorquesFollowItsNoise) {
  const Data d = data(3, 0.01, 8, 1e-3);
  const VectorXd w = residual_weights(joint_totals(d.recordings), Eigen::Vector2d(1, 1000), base(), names());
  EXPECT_NEAR(w[1] / w[0], 1e3, 0.1 * 1e3);
}

// An exact fit is known to the rounding of the torques' range, however many rows agree; a joint without rows has
// no weight.
TEST(ResidualWeights, OfAnExactFitAreLimitedByTheRoundingError) {
  const Eigen::Vector3d start(1e-3, 1e-4, 1.0);  // ranges far beyond the torques: their rounding is above the fit's
  const Eigen::Vector3d expected(start[0], start[1], 0.0);
  for (const int blocks : {1, 6}) {
    std::vector<SquareRootInformation> joints = joint_totals(data(blocks, 0.0, 9).recordings);
    joints.emplace_back(Names{"p0", "p2", "p3"});
    const VectorXd w = residual_weights(joints, start, base(), names());
    EXPECT_TRUE(near(std::numeric_limits<double>::epsilon() * w, expected, 1e-12));
  }
}

}  // namespace
}  // namespace veridyn
