#include "identification/base_solution.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "identification/estimation/least_squares.hpp"
#include "math/median.hpp"
#include "math/singular_values.hpp"
#include "math/clustered_statistics.hpp"

namespace veridyn {
namespace {

std::vector<std::string> independent_columns(const BaseParameters& base,
                                             const std::vector<std::string>& names) {
  std::vector<std::string> out;
  for (const int j : base.independent) out.push_back(names[j]);
  return out;
}

double condition_number(const MatrixXd& A) {
  const VectorXd s = singular_values(A);
  return s[s.size() - 1] > 0.0 ? s[0] / s[s.size() - 1] : std::numeric_limits<double>::infinity();
}

}  // namespace

std::vector<SquareRootInformation> joint_totals(
    const std::vector<CompressedRecording>& recordings) {
  std::vector<SquareRootInformation> joints(recordings.front().joints.size());
  for (const CompressedRecording& recording : recordings) {
    for (const auto& block : recording.blocks) {
      for (size_t i = 0; i < block.size(); ++i) joints[i].merge(block[i]);
    }
  }
  return joints;
}

SquareRootInformation weighted_total(const std::vector<SquareRootInformation>& joints,
                                     const VectorRef& weights,
                                     const std::vector<std::string>& columns) {
  SquareRootInformation total(columns);
  for (size_t i = 0; i < joints.size(); ++i) total.merge_known(joints[i], weights[static_cast<Eigen::Index>(i)]);
  return total;
}

BaseSolution solve_base(const std::vector<CompressedRecording>& recordings,
                        const VectorRef& weights, const BaseParameters& base,
                        const std::vector<std::string>& names) {
  const std::vector<std::string> columns = independent_columns(base, names);
  std::vector<SquareRootInformation> blocks;
  SquareRootInformation total(columns);
  for (const CompressedRecording& recording : recordings) {
    for (const auto& block : recording.blocks) {
      blocks.push_back(weighted_total(block, weights, columns));
      total.merge(blocks.back());
    }
  }
  BaseSolution out;
  out.beta = least_squares(total);
  out.residual2 = total.residual2(out.beta);
  out.condition_number = condition_number(total.R());
  MatrixXd scaled = total.R();
  for (Eigen::Index j = 0; j < scaled.cols(); ++j)
    scaled.col(j) /= std::max(scaled.col(j).norm(), 1e-300);
  out.condition_number_scaled = condition_number(scaled);
  const double freedom = std::max(1.0, total.rows() - total.size());
  const MatrixXd inverse =
      total.R().triangularView<Eigen::Upper>().solve(MatrixXd::Identity(total.size(), total.size()));
  out.white_std = inverse.rowwise().norm() * std::sqrt(out.residual2 / freedom);
  set_deviations(solutions_without(blocks), out);
  std::vector<double> ratios;
  for (Eigen::Index j = 0; j < out.beta.size(); ++j) {
    const double ratio = std::pow(out.white_std[j] / out.std[j], 2);
    if (std::isfinite(ratio)) ratios.push_back(ratio);
  }
  out.effective_samples = total.rows() * std::min(1.0, median(ratios));
  return out;
}

void set_deviations(const MatrixXd& without, BaseSolution& solution) {
  solution.clusters = static_cast<int>(without.cols());
  solution.scatter = solution.clusters < 3 ? MatrixXd(without.rows(), 0) : jackknife_factor(without);
  solution.std = solution.clusters < 3 ? VectorXd::Constant(without.rows(), std::numeric_limits<double>::quiet_NaN())
                                       : VectorXd(solution.scatter.rowwise().norm());
}

VectorXd range_weights(const std::vector<CompressedRecording>& recordings) {
  const auto n = static_cast<Eigen::Index>(recordings.front().joints.size());
  VectorXd weights = VectorXd::Ones(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    double low = 1e300;
    double high = -1e300;
    for (const CompressedRecording& r : recordings) {
      low = std::min(low, r.joints[i].minimum);
      high = std::max(high, r.joints[i].maximum);
    }
    // No sensor has a torque range as small as machine epsilon, whose squared reciprocal would overflow.
    if (high - low > std::numeric_limits<double>::epsilon()) weights[i] = 1.0 / (high - low);
  }
  return weights;
}

VectorXd residual_weights(const std::vector<SquareRootInformation>& joints,
                          const VectorRef& start, const BaseParameters& base,
                          const std::vector<std::string>& names) {
  const std::vector<std::string> columns = independent_columns(base, names);
  std::vector<SquareRootInformation> leading;
  for (const SquareRootInformation& joint : joints) leading.push_back(joint.restricted(columns));
  const VectorXd beta = least_squares(weighted_total(leading, start, columns));
  VectorXd weights(start.size());
  for (size_t i = 0; i < leading.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    // The residual cannot be smaller than the rounding errors of the torques: an exact fit gets a finite
    // weight.
    const double rounding = std::numeric_limits<double>::epsilon() / start[row];
    const double least = std::max(leading[i].rows(), 1.0) * rounding * rounding;
    weights[row] = std::sqrt(leading[i].rows() / std::max(leading[i].residual2(beta), least));
  }
  return weights;
}

}  // namespace veridyn
