#include "excitation/base_columns.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "regressor/arm_columns.hpp"
#include "excitation/search/column_choice.hpp"
#include "regressor/random_states.hpp"
#include "regressor/stacked_columns.hpp"
#include "excitation/search/base_regressor.hpp"
#include "veridyn/identification/base_parameters.hpp"

namespace veridyn {
namespace {

constexpr double kWorthwhile = 0.998;  // largest ratio of the condition numbers after and before a swap
constexpr double kAlike = 0.2;         // share of a new column that the replaced one must explain
constexpr double kNothing = 1e-9;      // a column below this share of the largest is zero
constexpr int kMaxSwaps = 50;

MatrixXd submatrix(const MatrixXd& gram, const std::vector<int>& rows, const std::vector<int>& cols) {
  return gram(rows, cols);
}

}  // namespace

EssentialColumns essential_columns(const Model& arm, double share) {
  const StackedColumns all(arm.joints(), arm_columns(arm, 0.0));
  const MatrixXd W = all.stacked(random_states(arm, state_count(all.count(), arm.joints())));
  const std::vector<int> order = preferred_columns(standard_parameters(arm));
  EssentialColumns out;
  out.kept = independent_columns(W, order, {}, share);
  improve_choice(W, out.kept);
  std::vector<int> before = out.kept;
  const MatrixXd unit = W.colwise().normalized();
  for (const int c : independent_columns(W, order, out.kept)) {
    const MatrixXd A = unit(Eigen::all, before);
    const VectorXd own = unit.col(c);
    out.non_essential.push_back({c, (own - A * A.householderQr().solve(own)).norm()});
    before.push_back(c);
  }
  return out;
}

MatrixXd gram_of_all_columns(const Model& arm, const MotionSamples& motion) {
  const StackedColumns all(arm.joints(), arm_columns(arm, 0.0));
  return all.gram(motion, VectorXd::Ones(arm.joints())) / static_cast<double>(motion.rows());
}

std::vector<int> best_conditioned_columns(const std::vector<int>& base, MatrixXd gram) {
  const VectorXd norms = gram.diagonal().cwiseSqrt();
  const double smallest = kNothing * norms.maxCoeff();
  std::vector<int> others;
  for (int c = 0; c < static_cast<int>(gram.rows()); ++c) {
    if (norms[c] > smallest && std::find(base.begin(), base.end(), c) == base.end())
      others.push_back(c);
  }
  const VectorXd inverse = norms.cwiseMax(smallest).cwiseInverse();
  gram = inverse.asDiagonal() * gram * inverse.asDiagonal();
  std::vector<int> best = base;
  double least = plain_condition_number(submatrix(gram, best, best));
  for (int swaps = 0; swaps < kMaxSwaps && std::isfinite(least) && !others.empty(); ++swaps) {
    // Share of each old column in each new one. A swap with a share of zero would make a parameter
    // unidentifiable.
    const MatrixXd share =
        submatrix(gram, best, best).llt().solve(submatrix(gram, best, others)).cwiseAbs();
    double reached = kWorthwhile * least;
    std::pair<size_t, size_t> swap{best.size(), 0};
    for (size_t o = 0; o < best.size(); ++o) {
      for (size_t n = 0; n < others.size(); ++n) {
        if (share(static_cast<Eigen::Index>(o), static_cast<Eigen::Index>(n)) < kAlike) continue;
        std::vector<int> next = best;
        next[o] = others[n];
        const double condition = plain_condition_number(submatrix(gram, next, next));
        if (condition < reached) {
          reached = condition;
          swap = {o, n};
        }
      }
    }
    if (swap.first == best.size()) break;
    std::swap(best[swap.first], others[swap.second]);
    least = reached;
  }
  return best;
}

}  // namespace veridyn
