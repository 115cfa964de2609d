#include "identification/estimation/additive_regression.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "math/random_numbers.hpp"

// Smooth terms are found on held-out rows: those that are there, and none where there is nothing.

namespace veridyn {
namespace {

constexpr int kSignals = 5;
constexpr int kFolds = 6;
constexpr int kSamples = 900;

FoldedRows random_rows(unsigned seed) {
  RandomNumbers random(seed);
  FoldedRows out;
  out.signals.resize(kSamples, kSignals);
  out.response.resize(kSamples);
  for (int r = 0; r < kSamples; ++r) {
    for (int s = 0; s < kSignals; ++s) out.signals(r, s) = random.uniform(-1.0, 1.0);
    out.response[r] = random.uniform(-1.0, 1.0);
  }
  for (int f = 0; f <= kFolds; ++f) out.fold_begin.push_back(f * kSamples / kFolds);
  return out;
}

std::vector<SmoothTerm> terms_of_one_signal() {
  std::vector<SmoothTerm> out;
  for (int s = 0; s < kSignals; ++s)
    out.push_back({{s}, {SmoothBasis(BasisKind::kSmooth, -1.0, 1.0, 10, 0.02)}, 1.0});
  return out;
}

AdditiveModel fitted(const FoldedRows& rows, const std::vector<SmoothTerm>& terms) {
  std::vector<MatrixXd> columns;
  for (const SmoothTerm& term : terms) columns.push_back(term.columns(rows.signals));
  return additive_regression(rows, terms, columns, {4, 0.05, 0.05}, EstimationNumbers());
}

TEST(AdditiveRegression, NoiseHasNoTerms) {
  for (unsigned seed = 1; seed <= 20; ++seed)
    EXPECT_TRUE(fitted(random_rows(seed), terms_of_one_signal()).chosen.empty()) << seed;
}

// An end stop of signal 2 and a wave of signal 4 under uniform noise of 0.58 rms.
TEST(AdditiveRegression, TheTermsThatAreThereAreFoundAndPredictNewRows) {
  const auto truth = [](double a, double b) {
    return 8.0 * std::pow(std::max(0.0, a - 0.4), 2) + std::sin(4.0 * b);
  };
  FoldedRows rows = random_rows(3);
  for (int r = 0; r < kSamples; ++r) rows.response[r] += truth(rows.signals(r, 2), rows.signals(r, 4));
  const std::vector<SmoothTerm> terms = terms_of_one_signal();
  const AdditiveModel model = fitted(rows, terms);
  ASSERT_EQ(model.chosen.size(), 2u);
  EXPECT_EQ(model.chosen[0].term + model.chosen[1].term, 6);
  EXPECT_EQ(std::abs(model.chosen[0].term - model.chosen[1].term), 2);
  const FoldedRows others = random_rows(4);
  VectorXd expected(kSamples);
  for (int r = 0; r < kSamples; ++r) expected[r] = truth(others.signals(r, 2), others.signals(r, 4));
  const VectorXd error = predicted(model, terms, others.signals) - expected;
  EXPECT_LT(std::sqrt(error.squaredNorm() / kSamples), 0.1);
}

// Two joints that move as one: what their small difference explains would take two straight lines of
// a hundred times the response that cancel.
TEST(AdditiveRegression, CurvesThatCancelAreRefused) {
  FoldedRows rows = random_rows(7);
  for (int r = 0; r < kSamples; ++r) {
    rows.response[r] += std::sin(4.0 * rows.signals(r, 0)) + rows.signals(r, 1);
    rows.signals(r, 1) = rows.signals(r, 0) + 0.01 * rows.signals(r, 1);
  }
  const std::vector<SmoothTerm> terms = terms_of_one_signal();
  const AdditiveModel model = fitted(rows, terms);
  ASSERT_FALSE(model.chosen.empty());
  for (size_t k = 0; k < model.chosen.size(); ++k) {
    const SmoothTerm& term = terms[model.chosen[k].term];
    VectorXd curve = term.columns(rows.signals) *
                     model.coefficients.segment(model.first_of(terms, k), term.size());
    curve.array() -= curve.mean();
    EXPECT_LT(curve.squaredNorm(), 4.0 * rows.response.squaredNorm()) << k;
  }
}

// A step at zero, and a function that has another sign on either side: no smooth one will do.
TEST(AdditiveRegression, StepsAndSidesAreFunctionsOfTheirOwn) {
  FoldedRows rows = random_rows(5);
  for (int r = 0; r < kSamples; ++r) {
    const double side = rows.signals(r, 0) > 0.0 ? 1.0 : -1.0;
    rows.response[r] += 2.0 * side * rows.signals(r, 1);
  }
  std::vector<SmoothTerm> terms = terms_of_one_signal();
  terms.push_back({{1, 0},
                   {SmoothBasis(BasisKind::kSmooth, -1.0, 1.0, 7, 0.02),
                    SmoothBasis(BasisKind::kSides, -1.0, 1.0, 1, 0.02)},
                   0.9});
  const AdditiveModel model = fitted(rows, terms);
  ASSERT_EQ(model.chosen.size(), 1u);
  EXPECT_EQ(model.chosen[0].term, 5);
  EXPECT_GT(model.gain, 0.5);
}

// What has no curvature has no smoothing to choose: the first is taken.
TEST(AdditiveRegression, ATermOfSidesNeedsNoSmoothing) {
  FoldedRows rows = random_rows(6);
  for (int r = 0; r < kSamples; ++r) rows.response[r] += rows.signals(r, 0) > 0.0 ? 1.5 : -1.5;
  const std::vector<SmoothTerm> terms = {{{0}, {SmoothBasis(BasisKind::kSides, -1.0, 1.0, 1, 1e-6)}, 1.0}};
  const AdditiveModel model = fitted(rows, terms);
  ASSERT_EQ(model.chosen.size(), 1u);
  EXPECT_EQ(model.chosen[0].smoothing, EstimationNumbers().least_smoothing);
  const auto own = model.coefficients.segment(model.first_of(terms, 0), terms[0].size());
  EXPECT_NEAR(own[1] - own[0], 3.0, 0.15);
}

TEST(SmoothBasis, IsAPartitionOfUnityAndConstantOutsideOfItsRange) {
  const SmoothBasis basis(BasisKind::kSmooth, -0.5, 2.0, 8, 0.01);
  VectorXd inside(basis.size());
  VectorXd end(basis.size());
  VectorXd beyond(basis.size());
  for (double x = -0.5; x <= 2.0; x += 0.1) {
    basis.values(x, inside.data());
    EXPECT_NEAR(inside.sum(), 1.0, 1e-12);
  }
  basis.values(2.0, end.data());
  basis.values(7.0, beyond.data());
  EXPECT_EQ((end - beyond).norm(), 0.0);
  // Straight lines cost nothing: their coefficients are one after the other.
  const VectorXd line = VectorXd::LinSpaced(basis.size(), 0.0, 1.0);
  EXPECT_NEAR(line.dot(basis.penalty() * line), 0.0, 1e-12);
}

}  // namespace
}  // namespace veridyn
