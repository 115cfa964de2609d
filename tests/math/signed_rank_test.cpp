#include "math/signed_rank.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace veridyn {
namespace {

// Critical values of the one-sided test at 5 %: the largest sum of negative ranks that is below it.
// Wilcoxon, Katti, Wilcox: Critical values and probability levels for the Wilcoxon rank sum test and
// the Wilcoxon signed rank test (1970).
TEST(SignedRank, AgreesWithTheTables) {
  struct Entry {
    int n, largest;
  };
  for (const Entry& e : {Entry{5, 0}, {6, 2}, {7, 3}, {8, 5}, {9, 8}, {10, 10}, {12, 17}, {20, 60}}) {
    const auto with_negative_sum = [&e](int sum) {
      std::vector<double> d;
      for (int rank = e.n; rank >= 1; --rank) {
        d.push_back(rank <= sum ? -rank : rank);
        if (rank <= sum) sum -= rank;
      }
      return signed_rank_p_value(d);
    };
    EXPECT_LE(with_negative_sum(e.largest), 0.05) << e.n;
    EXPECT_GT(with_negative_sum(e.largest + 1), 0.05) << e.n;
  }
}

// Against all 2^n choices of signs, counted one by one.
TEST(SignedRank, CountsEveryChoiceOfSigns) {
  const std::vector<double> d = {0.3, -0.1, 2.0, 0.7, -0.9, 1.1, 0.2};
  const auto negative_ranks = [&d](unsigned signs) {
    int sum = 0;
    for (size_t k = 0; k < d.size(); ++k) {
      int rank = 1;
      for (const double other : d) rank += static_cast<int>(std::abs(other) < std::abs(d[k]));
      sum += (signs >> k & 1U) != 0 ? rank : 0;
    }
    return sum;
  };
  unsigned own = 0;
  for (size_t k = 0; k < d.size(); ++k) own |= static_cast<unsigned>(d[k] < 0.0) << k;
  int as_clear = 0;
  for (unsigned signs = 0; signs < 128; ++signs)
    as_clear += static_cast<int>(negative_ranks(signs) <= negative_ranks(own));
  EXPECT_DOUBLE_EQ(signed_rank_p_value(d), as_clear / 128.0);
}

TEST(SignedRank, WithoutPositiveDifferencesIsNoEvidence) {
  EXPECT_DOUBLE_EQ(signed_rank_p_value({}), 1.0);
  EXPECT_DOUBLE_EQ(signed_rank_p_value({-1.0, -2.0, 0.0}), 1.0);
}

}  // namespace
}  // namespace veridyn
