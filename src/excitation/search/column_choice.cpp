#include "excitation/search/column_choice.hpp"

#include <Eigen/QR>
#include <algorithm>

namespace veridyn {
namespace {

constexpr double kRoundingError = 1e-12;  // columns below this share of the largest are zero
constexpr double kTie = 1e-9;             // remainders closer than this count as equal

constexpr double kWorthSwapping = 1.01;
constexpr int kMaxSwaps = 1000;  // each swap increases the volume, so that the loop ends anyway

}  // namespace

std::vector<int> independent_columns(const MatrixXd& W, const std::vector<int>& order,
                                     const std::vector<int>& taken, double least) {
  const VectorXd norms = W.colwise().norm().transpose();
  const double smallest = kRoundingError * norms.maxCoeff();
  MatrixXd left(W.rows(), W.cols());
  for (Eigen::Index c = 0; c < W.cols(); ++c) {
    left.col(c).setZero();
    if (norms[c] > smallest) left.col(c) = W.col(c) / norms[c];
  }
  const auto take = [&](int c) {
    const VectorXd direction = left.col(c).normalized();
    for (int again = 0; again < 2; ++again) left -= direction * (direction.transpose() * left);
  };
  for (const int c : taken) take(c);
  std::vector<int> chosen;
  std::vector<char> there(W.cols(), 0);
  while (chosen.size() < order.size()) {
    int best = -1;
    double most = std::max(least, kIndependent);
    for (const int c : order) {
      const double norm = there[c] ? 0.0 : left.col(c).norm();
      if (norm > (1.0 + kTie) * most) {
        best = c;
        most = norm;
      }
    }
    if (best < 0) break;
    take(best);
    there[best] = 1;
    chosen.push_back(best);
  }
  return chosen;
}

void improve_choice(const MatrixXd& W, std::vector<int>& chosen) {
  const double smallest = kRoundingError * W.colwise().norm().maxCoeff();
  std::vector<int> others;
  for (int c = 0; c < W.cols(); ++c) {
    if (std::find(chosen.begin(), chosen.end(), c) == chosen.end() && W.col(c).norm() > smallest)
      others.push_back(c);
  }
  if (others.empty()) return;
  const MatrixXd unit = W.colwise().normalized();
  for (int swaps = 0; swaps < kMaxSwaps; ++swaps) {
    // The other columns in terms of the chosen ones; an entry above one is the factor by which a
    // swap increases the volume.
    const MatrixXd T = unit(Eigen::all, chosen).householderQr().solve(unit(Eigen::all, others));
    Eigen::Index out = 0;
    Eigen::Index in = 0;
    if (T.cwiseAbs().maxCoeff(&out, &in) <= kWorthSwapping) return;
    std::swap(chosen[out], others[in]);
  }
}

}  // namespace veridyn
