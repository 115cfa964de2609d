#pragma once

#include <memory>
#include <vector>

#include "regressor/column_source.hpp"

namespace veridyn {

/// The Gram matrix of chosen columns of several sources, and its derivative. Several threads may use one
/// object, except for choose().
class StackedColumns {
 public:
  StackedColumns(int joints, std::vector<std::shared_ptr<const ColumnSource>> sources);

  /// Number of columns of all sources; those of the first source come first.
  int count() const { return count_; }

  /// Selects the columns of gram() and their order; initially all.
  void choose(const std::vector<int>& columns);
  int chosen() const { return chosen_; }

  /// All columns, chosen or not: (rows n x count), the rows of joint 1 first.
  MatrixXd stacked(const MotionSamples& motion) const;

  /// The sum over i of w_i^2 W_i' W_i, of the chosen columns.
  /// @param row_weights  (n) weights w.
  MatrixXd gram(const MotionSamples& motion, const VectorXd& row_weights) const;

  /// The Gram matrix W_i' W_i of each joint's rows.
  std::vector<MatrixXd> joint_grams(const MotionSamples& motion) const;

  /// The derivatives of f(joint_grams) with respect to q, dq, ddq of every row, (rows x 3 n).
  /// @param by_gram  (n of chosen x chosen) df/dG_i, symmetric.
  MatrixXd gradient(const MotionSamples& motion, const std::vector<MatrixXd>& by_gram) const;

  /// The derivatives of f(gram) with respect to q, dq, ddq of every row, (rows x 3 n).
  /// @param by_gram  (chosen x chosen) df/dgram, symmetric.
  MatrixXd gradient(const MotionSamples& motion, const VectorXd& row_weights,
                    const MatrixXd& by_gram) const;

 private:
  // Location of a chosen column in a joint's rows.
  struct Place {
    size_t source;
    int local;   ///< index among the source's columns of that joint
    int column;  ///< index among the chosen columns
  };

  std::vector<std::vector<MatrixXd>> evaluate(const MotionSamples& motion) const;  ///< by source and joint, see ColumnSource::evaluate()
  MatrixXd rows_of(size_t joint, const std::vector<std::vector<MatrixXd>>& Y,
                   Eigen::Index rows) const;  ///< chosen columns in a joint's rows, in the order of its places_

  std::vector<std::shared_ptr<const ColumnSource>> sources_;
  std::vector<std::vector<std::vector<int>>> columns_;  // by source and joint; indices among all columns
  std::vector<std::vector<Place>> places_;              // by joint
  int count_ = 0;
  int chosen_ = 0;
};

}  // namespace veridyn
