#include "diagnosis/unnamed/shared_residual.hpp"

#include <cmath>
#include <map>
#include <vector>

namespace veridyn {
namespace {

struct Moments {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, yy = 0.0, xy = 0.0;

  void add(double a, double b) {
    n += 1.0;
    x += a;
    y += b;
    xx += a * a;
    yy += b * b;
    xy += a * b;
  }

  double correlation() const {
    const double both = (xx - x * x / n) * (yy - y * y / n);
    return n > 1.0 && both > 0.0 ? (xy - x * y / n) / std::sqrt(both) : 0.0;
  }
};

// 0 where the folds disagree on its sign.
double correlation_of_all_folds(const MotionRows& rows, const std::vector<int>& fold, int joint, int other) {
  Moments all;
  std::map<int, Moments> of_folds;
  for (Eigen::Index r = 0; r < rows.residual.rows(); ++r) {
    if (!rows.used(r, joint) || !rows.used(r, other)) continue;
    all.add(rows.residual(r, joint), rows.residual(r, other));
    of_folds[fold[r]].add(rows.residual(r, joint), rows.residual(r, other));
  }
  const double out = all.correlation();
  for (const auto& [name, some] : of_folds) {
    if (some.correlation() * out <= 0.0) return 0.0;
  }
  return out;
}

}  // namespace

std::optional<SharedResidual> shared_residual(const MotionRows& train, int joint, const Thresholds& limits) {
  std::optional<SharedResidual> out;
  const std::vector<int> fold = folds_of(train, limits);
  for (int other = 0; other < train.residual.cols(); ++other) {
    if (other == joint) continue;
    const double correlation = correlation_of_all_folds(train, fold, joint, other);
    const double most = out ? std::abs(out->correlation) : std::sqrt(limits.unnamed_share);
    if (std::abs(correlation) > most) out = SharedResidual{other, correlation};
  }
  return out;
}

}  // namespace veridyn
