#include "excitation/base_columns.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "regressor/arm_columns.hpp"
#include "excitation/search/column_choice.hpp"
#include "regressor/random_states.hpp"
#include "regressor/stacked_columns.hpp"
#include "excitation/search/base_regressor.hpp"
#include "veridyn/excitation/excitation.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

MatrixXd unit_columns(const Model& arm, const MotionSamples& motion) {
  return StackedColumns(arm.joints(), arm_columns(arm, 0.0)).stacked(motion).colwise().normalized();
}

// What least squares cannot explain of a column by others.
double regression_remainder(const MatrixXd& W, int column, std::vector<int> others) {
  others.erase(std::remove(others.begin(), others.end(), column), others.end());
  const MatrixXd A = W(Eigen::all, others);
  const VectorXd b = W.col(column);
  return (b - A * A.colPivHouseholderQr().solve(b)).norm();
}

// Front and intermediate bars of the wrist's arm never turn against each other: of their first
// moments only a sum is seen, but for an offset of 38 mm.
TEST(BaseColumns, EssentialColumnsAddMoreThanTheShareAndOthersLess) {
  const Model arm = read_model("psm-wrist");
  const BaseRegressor all(arm);
  const MatrixXd W = unit_columns(arm, random_states(arm, 300));
  for (const double share : {0.001, 0.01, 0.1}) {
    const EssentialColumns e = essential_columns(arm, share);
    EXPECT_EQ(static_cast<int>(e.kept.size() + e.non_essential.size()), all.size());
    // The states are others: a tenth either way.
    for (const int c : e.kept) EXPECT_GT(regression_remainder(W, c, e.kept), 0.9 * 1e-3) << c;
    for (const WeakColumn& weak : e.non_essential) {
      EXPECT_LT(regression_remainder(W, weak.column, e.kept), 1.1 * share) << weak.column;
      EXPECT_LE(weak.share, share);
    }
  }
  EXPECT_EQ(essential_columns(arm, 0.01).non_essential.size(), 2u);
  EXPECT_TRUE(essential_columns(arm, 1e-6).non_essential.empty());
}

TEST(BaseColumns, TheBestConditionedColumnsSpanTheSameSpace) {
  const Model arm = read_model("psm-3dof");
  ExcitationOptions options;
  options.solver = ExcitationSolver::kRandom;
  options.iterations = 1;
  options.starts = 1;
  options.frequency = 0.1;
  const MotionSamples motion = optimise_excitation(arm, options).motion;
  const BaseRegressor before(arm);
  const std::vector<int> chosen =
      best_conditioned_columns(before.base(), gram_of_all_columns(arm, motion));
  ASSERT_EQ(chosen.size(), before.base().size());
  const double was = scaled_condition_number(before.gram(motion));
  const double is = scaled_condition_number(BaseRegressor(arm, chosen).gram(motion));
  EXPECT_LE(is, was);
  const MatrixXd W = unit_columns(arm, random_states(arm, 100));
  for (const int c : before.base()) {
    const bool kept = std::find(chosen.begin(), chosen.end(), c) != chosen.end();
    EXPECT_LT(kept ? 0.0 : regression_remainder(W, c, chosen), 1e-9) << c;
  }
}

// A choice that is spoilt on purpose is repaired.
TEST(BaseColumns, SwapsMakeTheConditionNumberSmaller) {
  // Columns a, b and a + b: the pair (a, a + b) is worse conditioned than (a, b).
  MatrixXd W(2, 3);
  W << 1.0, 0.0, 1.0, 0.0, 1.0, 1.0;
  const std::vector<int> chosen = best_conditioned_columns({0, 2}, W.transpose() * W);
  EXPECT_NE(std::find(chosen.begin(), chosen.end(), 1), chosen.end());
}

TEST(BaseColumns, EssentialParametersOfTheWristAreWellConditioned) {
  ExcitationOptions options;
  options.frequency = 0.18;
  options.harmonics = 6;
  options.starts = 1;
  options.iterations = 15;
  options.essential = 0.01;
  options.criterion = ExcitationCriterion::kCondition;
  options.limit_share = 1.0;
  const Excitation e = optimise_excitation(read_model("psm-wrist"), options);
  ASSERT_EQ(e.status, ExcitationStatus::kDone);
  ASSERT_TRUE(e.essential.has_value());
  EXPECT_EQ(e.essential->count, 47);
  EXPECT_EQ(e.base_parameters, 49);
  EXPECT_LT(e.essential->condition_number, 60.0);
  EXPECT_GT(e.condition_number, 1000.0);
}

}  // namespace
}  // namespace veridyn
