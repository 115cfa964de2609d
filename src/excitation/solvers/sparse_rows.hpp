#pragma once

#include <utility>
#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Rows of a sparse Jacobian with a constant pattern.
class SparseRows {
 public:
  SparseRows(const std::vector<std::pair<int, int>>& pattern, Eigen::Index rows)
      : begin_(static_cast<size_t>(rows) + 1, 0) {
    for (const auto& entry : pattern) ++begin_[entry.first + 1];
    for (size_t r = 1; r < begin_.size(); ++r) begin_[r] += begin_[r - 1];
    std::vector<size_t> next(begin_.begin(), begin_.end() - 1);
    place_.resize(pattern.size());
    column_.resize(pattern.size());
    for (size_t e = 0; e < pattern.size(); ++e) {
      const size_t to = next[pattern[e].first]++;
      place_[e] = static_cast<Eigen::Index>(to);
      column_[to] = pattern[e].second;
    }
    values_.resize(static_cast<Eigen::Index>(pattern.size()));
  }

  /// @param values  values of the entries in the order of the pattern.
  void set(const VectorXd& values) {
    for (size_t e = 0; e < place_.size(); ++e)
      values_[place_[e]] = values[static_cast<Eigen::Index>(e)];
  }

  VectorXd times(const VectorXd& x) const {
    VectorXd out = VectorXd::Zero(static_cast<Eigen::Index>(begin_.size()) - 1);
    for (size_t r = 0; r + 1 < begin_.size(); ++r) {
      double sum = 0.0;
      for (size_t e = begin_[r]; e < begin_[r + 1]; ++e)
        sum += values_[static_cast<Eigen::Index>(e)] * x[column_[e]];
      out[static_cast<Eigen::Index>(r)] = sum;
    }
    return out;
  }

  /// The product J' y.
  VectorXd transposed_times(const VectorXd& y, Eigen::Index columns) const {
    VectorXd out = VectorXd::Zero(columns);
    for (size_t r = 0; r + 1 < begin_.size(); ++r) {
      const double share = y[static_cast<Eigen::Index>(r)];
      for (size_t e = begin_[r]; e < begin_[r + 1]; ++e)
        out[column_[e]] += share * values_[static_cast<Eigen::Index>(e)];
    }
    return out;
  }

  /// Adds J' diag(weights) J to the lower triangle of A; columns ascend within a row.
  void add_normal(const VectorXd& weights, MatrixXd& A) const {
    for (size_t r = 0; r + 1 < begin_.size(); ++r) {
      const double weight = weights[static_cast<Eigen::Index>(r)];
      for (size_t b = begin_[r]; b < begin_[r + 1]; ++b) {
        const double share = weight * values_[static_cast<Eigen::Index>(b)];
        double* to = &A(0, column_[b]);
        for (size_t a = b; a < begin_[r + 1]; ++a)
          to[column_[a]] += share * values_[static_cast<Eigen::Index>(a)];
      }
    }
  }

 private:
  std::vector<size_t> begin_;
  std::vector<Eigen::Index> place_;  // for each entry, its index in the pattern
  std::vector<int> column_;
  VectorXd values_;
};

}  // namespace veridyn
