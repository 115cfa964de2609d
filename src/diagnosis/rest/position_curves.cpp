#include "diagnosis/rest/position_curves.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "diagnosis/findings/held_out.hpp"
#include "diagnosis/numerics.hpp"
#include "math/decompositions.hpp"

namespace veridyn {

PositionCurves::PositionCurves(const Identification& at_rest, const Thresholds& limits) {
  const HoldOut how = hold_out(limits);
  const std::vector<RecordingError>& all = at_rest.train;
  const size_t parts = how.parts_of_each(all.size()), most = 2 * how.parts_of_each(1);
  for (size_t r = 0; r < all.size(); ++r) {
    const size_t count = all[r].series.time.size();
    for (size_t k = 0; k < count; ++k) poses_.push_back({&all[r].series, k, (r * parts + k * parts / count) % most});
  }
  const size_t every = (poses_.size() + numerics::kMostPoses - 1) / numerics::kMostPoses;
  for (size_t k = 1; k * every < poses_.size(); ++k) poses_[k] = poses_[k * every];
  if (every > 1) poses_.resize((poses_.size() + every - 1) / every);
  std::stable_sort(poses_.begin(), poses_.end(), [](const Pose& a, const Pose& b) { return a.fold < b.fold; });
  const auto count = static_cast<Eigen::Index>(poses_.size());
  for (Eigen::Index k = 0; k < count; ++k) {
    if (k == 0 || poses_[k].fold != poses_[k - 1].fold) fold_begin_.push_back(k);
  }
  fold_begin_.push_back(count);
  MatrixXd sum = MatrixXd::Zero(count, count), squares = sum;
  for (int i = 0; i < at_rest.model->joints(); ++i) {
    VectorXd q(count);
    for (Eigen::Index k = 0; k < count; ++k) q[k] = poses_[k].of->q[i][poses_[k].at];
    const double range = count > 0 ? q.maxCoeff() - q.minCoeff() : 0.0;
    if (!(range > limits.still(at_rest.model->coordinates()[i].prismatic))) continue;
    const MatrixXd apart = q.replicate(1, count).rowwise() - q.transpose();
    const MatrixXd own = (-0.5 * (apart / (numerics::kCurveWidth * range)).array().square()).exp();
    sum += own;
    squares += own.cwiseAbs2();
  }
  if (count == 0 || sum(0, 0) == 0.0) return;
  const MatrixXd kernel = sum + 0.5 * (sum.cwiseAbs2() - squares);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(kernel / kernel(0, 0));
  vectors_ = eigen.eigenvectors();
  values_ = eigen.eigenvalues().cwiseMax(0.0);
}

double PositionCurves::predicted_share(int joint) const {
  if (fold_begin_.size() < 3 || values_.size() == 0) return 0.0;
  VectorXd y(values_.size());
  for (Eigen::Index k = 0; k < y.size(); ++k)
    y[k] = poses_[k].of->measured[joint][poses_[k].at] - poses_[k].of->modelled[joint][poses_[k].at];
  y.array() -= y.mean();
  double best = 0.0;
  for (const double ridge : numerics::kCurveRidges) {
    const VectorXd shrink = values_.array() / (values_.array() + ridge);
    const VectorXd left = y - vectors_ * shrink.cwiseProduct(vectors_.transpose() * y);
    double error2 = 0.0;
    bool better = true;
    for (size_t f = 0; f + 1 < fold_begin_.size(); ++f) {
      // Residual of this fold under the fit to the other folds.
      const Eigen::Index at = fold_begin_[f], size = fold_begin_[f + 1] - at;
      const auto own = vectors_.middleRows(at, size);
      const MatrixXd rest = MatrixXd::Identity(size, size) - own * shrink.asDiagonal() * own.transpose();
      const double fold2 = rest.ldlt().solve(left.segment(at, size)).squaredNorm();
      error2 += fold2;
      better = better && fold2 < y.segment(at, size).squaredNorm();
    }
    if (better) best = std::max(best, 1.0 - error2 / std::max(y.squaredNorm(), numerics::kTiny));
  }
  return best;
}

}  // namespace veridyn
