#include "diagnosis/evidence/bordered_fit.hpp"

#include <gtest/gtest.h>

#include "support/near.hpp"

// The bordered solution against the plain one, which solves for all columns at once.

namespace veridyn {
namespace {

constexpr int kColumns = 9;
constexpr int kBlocks = 3;

std::string column_name(int k) {
  return "c" + std::to_string(k);
}

// Two joints, three blocks of thirty rows; joint 1 does not have the last column.
CompressedRecording random_recording() {
  std::srand(7);
  CompressedRecording out;
  out.joints.resize(2);
  for (int b = 0; b < kBlocks; ++b) {
    std::vector<SquareRootInformation> block;
    for (int j = 0; j < 2; ++j) {
      std::vector<std::string> names;
      for (int k = 0; k < kColumns - j; ++k) names.push_back(column_name(k));
      SquareRootInformation factor(names);
      factor.absorb(MatrixXd::Random(30, kColumns - j), VectorXd::Random(30));
      block.push_back(factor);
    }
    out.blocks.push_back(block);
  }
  return out;
}

NormalBlocks blocks() {
  std::vector<std::string> names;
  for (int k = 0; k < kColumns; ++k) names.push_back(column_name(k));
  return NormalBlocks({random_recording()}, names);
}

class Bordered : public testing::TestWithParam<ColumnSet> {};

INSTANTIATE_TEST_SUITE_P(Set, Bordered,
                         testing::Values(ColumnSet{}, ColumnSet{0}, ColumnSet{4, 1, 0, 2}));

TEST_P(Bordered, IsTheSolutionOfAllColumnsTogether) {
  const NormalBlocks data = blocks();
  const ColumnSet set = GetParam();
  const ColumnSet more = {7, 8};
  const VectorXd w = (VectorXd(2) << 2.0, 0.3).finished();
  const BorderedFit fit(set, w, data.total(), &data.cluster(1), &data.cluster(1));
  ColumnSet all = set;
  all.insert(all.end(), more.begin(), more.end());
  const VectorXd x = data.solve(all, w, data.total(), &data.cluster(1));
  const BorderedFit::Border border = fit.with(more);
  EXPECT_TRUE(near(border.values, VectorXd(x.tail(2)), 1e-8));
  EXPECT_TRUE(near(border.residual2, data.residual2(all, x, data.cluster(1)), 1e-8));
  const VectorXd alone = data.solve(set, w, data.total(), &data.cluster(1));
  EXPECT_TRUE(near(fit.residual2(), data.residual2(set, alone, data.cluster(1)), 1e-8));
}

TEST(Bordered, AColumnOfTheSetBringsNothingNew) {
  const NormalBlocks data = blocks();
  const ColumnSet set = {0, 1, 2};
  const BorderedFit fit(set, VectorXd::Ones(2), data.total(), nullptr, nullptr);
  EXPECT_LT(fit.with({1}).new_share, 1e-9);
  EXPECT_GT(fit.with({5}).new_share, 0.5);
}

}  // namespace
}  // namespace veridyn
