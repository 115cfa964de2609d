#pragma once

#include <vector>

namespace veridyn {

/// Wilcoxon's signed-rank test, one-sided: the probability that paired differences symmetric about
/// zero favour the positive side at least as much as these do. Exact, by counting all 2^n choices
/// of signs; differences of zero count as negative, and ties keep their order. Source: Wilcoxon,
/// Biometrics Bulletin 1(6), 1945.
/// @return 1 without differences.
double signed_rank_p_value(const std::vector<double>& differences);

}  // namespace veridyn
