#include "model/correlated_joints.hpp"

#include <cmath>
#include <string>

namespace veridyn {

std::vector<std::vector<JointIndex>> correlated_joints(const MatrixXd& q, double least) {
  const Eigen::Index n = q.cols();
  VectorXd mean = VectorXd::Zero(n);
  double rows = 0.0;
  for (Eigen::Index r = 0; r < q.rows(); ++r) {
    if (!q.row(r).allFinite()) continue;
    mean += q.row(r).transpose();
    rows += 1.0;
  }
  if (rows < 2.0) return {};
  mean /= rows;
  MatrixXd products = MatrixXd::Zero(n, n);
  for (Eigen::Index r = 0; r < q.rows(); ++r) {
    if (!q.row(r).allFinite()) continue;
    const VectorXd x = q.row(r).transpose() - mean;
    products += x * x.transpose();
  }
  constexpr double kHardly = 1e-6;  // [rad] or [m] rms change below which a position counts as constant
  std::vector<char> taken(n, 0);
  std::vector<std::vector<JointIndex>> out;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (taken[i] != 0 || std::sqrt(products(i, i) / rows) < kHardly) continue;
    std::vector<JointIndex> group = {{static_cast<int>(i)}};
    for (Eigen::Index k = i + 1; k < n; ++k) {
      if (taken[k] != 0 || std::sqrt(products(k, k) / rows) < kHardly) continue;
      if (std::abs(products(i, k)) < least * std::sqrt(products(i, i) * products(k, k))) continue;
      group.push_back({static_cast<int>(k)});
      taken[k] = 1;
    }
    if (group.size() > 1) out.push_back(std::move(group));
  }
  return out;
}

std::string numbers_from_one(const std::vector<JointIndex>& joints) {
  std::string out;
  for (size_t k = 0; k < joints.size(); ++k) {
    out += (k == 0 ? "" : k + 1 == joints.size() ? " and " : ", ") + std::to_string(joints[k].value + 1);
  }
  return out;
}

}  // namespace veridyn
