#include "identification/drive_gains/gain_problem.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/near.hpp"
#include "support/random.hpp"

// Currents of three joints that share unknowns, in plain numbers.

namespace veridyn {
namespace {

constexpr int kUnknowns = 8;
constexpr int kRows = 60;

struct Truth {
  VectorXd x;
  Eigen::Vector3d p;
};

Truth truth() {
  Random random(3);
  return {random.vector(kUnknowns, -2, 2), Eigen::Vector3d(0.1, 0.7, 4.0)};
}

// The first joint feels all of what is known, the second a little, the third nothing.
std::vector<GainEquation> equations(double noise, unsigned seed, double known = 1.0) {
  const Truth t = truth();
  Random random(7);
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  std::vector<GainEquation> out(3);
  for (size_t j = 0; j < 3; ++j) {
    GainEquation& e = out[j];
    e.U = MatrixXd::Zero(kRows, kUnknowns);
    // Neighbours have four unknowns in common.
    for (Eigen::Index c = 0; c < kUnknowns; ++c) {
      if (c < 2 * static_cast<Eigen::Index>(j) || c > 2 * static_cast<Eigen::Index>(j) + 3)
        continue;
      e.U.col(c) = random.vector(kRows, -1, 1);
    }
    e.k = (j == 0 ? 1.0 : j == 1 ? 0.2 : 0.0) * random.vector(kRows, -1, 1);
    const auto i = static_cast<Eigen::Index>(j);
    e.z = t.p[i] * (e.U * t.x + known * e.k);
    const double size = e.z.norm() / std::sqrt(kRows);
    for (double& z : e.z) z += noise * size * normal(engine);
    e.rows = kRows;
  }
  return out;
}

VectorXd sigma(const std::vector<GainEquation>& all, double noise) {
  VectorXd out(3);
  for (int j = 0; j < 3; ++j)
    out[j] = std::max(noise, 1e-3) * all[j].z.norm() / std::sqrt(kRows);
  return out;
}

TEST(TheGainProblem, RecoversTheTruthWithoutNoise) {
  const std::vector<GainEquation> all = equations(0.0, 1);
  const GainSolution s = solve_gains(all, sigma(all, 0), start_gains(all, sigma(all, 0)));
  EXPECT_TRUE(s.converged);
  EXPECT_TRUE(near(s.p(), truth().p, 1e-8));
  EXPECT_TRUE(near(s.y / s.scale, truth().x, 1e-7));
}

// At the optimum no parameter lowers the cost: central differences of it vanish.
TEST(TheGainProblem, TerminatesOnAFlatCost) {
  const std::vector<GainEquation> all = equations(0.1, 2);
  const VectorXd w = sigma(all, 0.1);
  const GainSolution s = solve_gains(all, w, start_gains(all, w));
  const auto cost = [&](const GainSolution& at) {
    const VectorXd r = residual_current(all, at);
    double sum = 0.0;
    for (int j = 0; j < 3; ++j) sum += kRows * std::pow(r[j] / w[j], 2);
    return sum;
  };
  EXPECT_NEAR(cost(s), s.cost, 1e-9 * s.cost);
  const auto expect_flat = [&](double GainSolution::*member) {
    GainSolution up = s;
    GainSolution down = s;
    up.*member += 1e-4 * std::abs(s.*member);
    down.*member -= 1e-4 * std::abs(s.*member);
    EXPECT_GT(cost(up), cost(s));
    EXPECT_GT(cost(down), cost(s));
    EXPECT_NEAR(cost(up), cost(down), 1e-2 * (cost(up) - cost(s)));
  };
  expect_flat(&GainSolution::scale);
  for (Eigen::Index j = 0; j < 3; ++j) {
    if (j == s.reference) continue;
    for (const double sign : {1.0, -1.0}) {
      GainSolution moved = s;
      moved.ratio[j] *= 1.0 + sign * 1e-3;
      EXPECT_GT(cost(moved), cost(s)) << j;
    }
  }
}

// Noise is in the currents: gains are right on average, not too small as they come from a fit that
// has the currents among its columns. There, with noise of 20 % of the joint's current and the
// known torque a tenth of it, the third joint would lose more than a tenth.
TEST(TheGainProblem, IsNotBiasedByNoise) {
  const int draws = 300;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d square = Eigen::Vector3d::Zero();
  for (int k = 0; k < draws; ++k) {
    const std::vector<GainEquation> all = equations(0.2, static_cast<unsigned>(100 + k));
    const VectorXd w = sigma(all, 0.2);
    const Eigen::Vector3d p = solve_gains(all, w, start_gains(all, w)).p();
    const Eigen::Vector3d relative = p.cwiseQuotient(truth().p);
    mean += relative / draws;
    square += relative.cwiseAbs2() / draws;
  }
  const Eigen::Vector3d deviation = (square - mean.cwiseAbs2()).cwiseSqrt();
  for (int j = 0; j < 3; ++j) {
    // Three standard errors, and the curvature of the problem: the square of the deviation.
    const double allowed = 3.0 * deviation[j] / std::sqrt(draws) + 2.0 * std::pow(deviation[j], 2);
    EXPECT_NEAR(mean[j], 1.0, allowed) << j;
    EXPECT_LT(deviation[j], 0.25) << j;
  }
}

// Nothing of the known torque is in the currents: the scale is zero within its scatter, and the
// currents are explained all the same.
TEST(TheGainProblem, HasAFiniteSolutionWithoutAKnownTorque) {
  const std::vector<GainEquation> all = equations(0.05, 5, 0.0);
  const VectorXd w = sigma(all, 0.05);
  const GainSolution s = solve_gains(all, w, start_gains(all, w));
  EXPECT_TRUE(s.y.allFinite());
  EXPECT_LT(std::abs(s.p()[0]), 0.05 * truth().p[0]);
  const VectorXd left = residual_current(all, s);
  for (int j = 0; j < 3; ++j) EXPECT_LT(left[j], 1.2 * w[j]);
}

// A joint that shares no unknowns with one that feels what is known has no scale of its own.
TEST(TheGainProblem, MarksUndeterminedGains) {
  std::vector<GainEquation> all = equations(0.02, 6);
  all[2].U.leftCols(6).setZero();  // unknowns 6 and 7 are its own
  all[2].z = 3.0 * (all[2].U * truth().x);
  const VectorXd w = sigma(all, 0.02);
  const GainSolution s = solve_gains(all, w, start_gains(all, w));
  const VectorXd shares = independent_shares(all, w, s);
  EXPECT_GT(shares[0], 1e-2);
  EXPECT_GT(shares[1], 1e-3);
  EXPECT_LT(shares[2], 1e-9);
  EXPECT_NEAR(s.p()[0] / truth().p[0], 1.0, 0.05);
  EXPECT_LT(residual_current(all, s)[2], 1e-6 * all[2].z.norm());
}

}  // namespace
}  // namespace veridyn
