#include "diagnosis/comparison/comparison_statistics.hpp"

#include <algorithm>
#include <cmath>

#include "math/numbers.hpp"
#include "math/student_t.hpp"
#include "diagnosis/comparison/comparison_numbers.hpp"

namespace veridyn {
namespace {

// Degrees of freedom of a sum of squares that a few clusters may dominate: Satterthwaite's (sum v)^2 / sum
// v^2 for normal contributions of variances v_c, with d_c^4 in place of 3 v_c^2, corrected for the value that
// equal clusters give by chance.
double degrees_of_freedom(const VectorXd& scatter, int clusters) {
  const double most = std::max(1, clusters - 1);
  if (scatter.size() != clusters) return most;  // no longer one column per cluster
  const double fourth = scatter.array().pow(4).sum();
  if (!(fourth > 0.0)) return most;
  const double spread = comparing::kKurtosis * std::pow(scatter.squaredNorm(), 2) / fourth - 2.0;
  return std::clamp(spread, 0.5 * most, most);
}

}  // namespace

void add_statistics(const VectorXd& scatter_before, const VectorXd& scatter_after,
                    const ClusterStatistics& how, ModelDifference& d) {
  d.difference = d.after - d.before;
  d.deviation = kNaN;
  if (how.clusters_before == 0 && how.clusters_after == 0) return;
  double variance = 0.0;
  if (how.paired) {
    const VectorXd scatter = scatter_after - scatter_before;
    variance = scatter.squaredNorm();
    d.degrees_of_freedom = degrees_of_freedom(scatter, how.clusters_before);
  } else {
    const double va = scatter_before.squaredNorm();
    const double vb = scatter_after.squaredNorm();
    variance = va + vb;
    const double parts = va * va / degrees_of_freedom(scatter_before, how.clusters_before) +
                         vb * vb / degrees_of_freedom(scatter_after, how.clusters_after);
    d.degrees_of_freedom = parts > 0.0 ? variance * variance / parts
                                       : std::max(how.clusters_before, how.clusters_after) - 1.0;
  }
  const double rounding = comparing::kSameToRounding * std::max(std::abs(d.before), std::abs(d.after));
  d.deviation = std::sqrt(variance + rounding * rounding);
  if (!(d.deviation > 0.0)) return;
  d.t = d.difference / d.deviation;
  d.p_value = student_t_two_sided(d.t, d.degrees_of_freedom);
  const double reach = d.deviation * student_t_quantile(comparing::kOutside, d.degrees_of_freedom);
  d.low = d.difference - reach;
  d.high = d.difference + reach;
}

// Holm's correction: the k-th smallest p-value of m is multiplied by m - k + 1, and never below the
// previous one.
void correct_for_number(ModelComparison& c) {
  std::vector<ModelDifference*> all;
  for (ModelDifference& d : c.joints) {
    if (d.same_as.empty()) all.push_back(&d);
  }
  for (ModelDifference& d : c.parameters) all.push_back(&d);
  std::sort(all.begin(), all.end(), [](const ModelDifference* x, const ModelDifference* y) {
    return x->p_value < y->p_value;
  });
  double least = 0.0;
  for (size_t k = 0; k < all.size(); ++k) {
    least = std::max(least, std::min(1.0, all[k]->p_value * static_cast<double>(all.size() - k)));
    all[k]->p_corrected = least;
    all[k]->significant = least < c.significance;
  }
  for (ModelDifference& joint : c.joints) {
    for (const ModelDifference& d : c.parameters) {
      if (joint.same_as.empty() || joint.same_as != d.expression) continue;
      joint.p_corrected = d.p_corrected;
      joint.significant = d.significant;
    }
  }
}

}  // namespace veridyn
