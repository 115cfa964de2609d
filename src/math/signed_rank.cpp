#include "math/signed_rank.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace veridyn {

double signed_rank_p_value(const std::vector<double>& differences) {
  std::vector<double> sorted = differences;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](double a, double b) { return std::abs(a) < std::abs(b); });
  const size_t n = sorted.size();
  size_t negative = 0;  // sum of the ranks of negative differences
  for (size_t k = 0; k < n; ++k) negative += sorted[k] > 0.0 ? 0 : k + 1;
  // ways[s]: share of all choices of signs whose negative ranks sum to s.
  std::vector<double> ways(n * (n + 1) / 2 + 1, 0.0);
  ways[0] = 1.0;
  for (size_t rank = 1; rank <= n; ++rank) {
    for (size_t s = ways.size(); s-- > 0;)
      ways[s] = 0.5 * (ways[s] + (s >= rank ? ways[s - rank] : 0.0));
  }
  double p = 0.0;
  for (size_t s = 0; s <= negative; ++s) p += ways[s];
  return std::min(p, 1.0);
}

}  // namespace veridyn
