#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/search/search.hpp"

namespace veridyn::search {

/// True for the direction of gravity.
bool is_tilt(const Term& t);

/// True for a factor of a recorded torque.
bool is_factor(const Term& t);

/// The terms that the search has chosen so far, with the arm that contains their corrections. A search changes the set and
/// evaluates it with and without each term.
class CurrentSet {
 public:
  CurrentSet(const Model& arm, const SearchRequest& request);

  std::vector<Chosen> terms;

  const Rows& rows() const { return *rows_; }
  const std::shared_ptr<const Rows>& shared_rows() const { return rows_; }
  const Folds& folds() const { return folds_; }
  const Base& base() const { return base_; }
  const Eigen::Vector3d& gravity() const { return arm_.gravity(); }  ///< gravity of the file
  const std::vector<Term>& dictionary() const { return dictionary_; }
  bool is_empty() const { return folds_.count == 0 || rows_->rows() == 0; }
  /// True if every term is tested again on held-out recordings. Changes of a MODEL are not, because they may
  /// differ between recordings.
  bool is_repeated() const { return !request_.test.empty() && !request_.scope.changes; }

  /// Weights and factors of the current set; the weights start from those of the last round.
  Round round();
  /// First column of the k-th term in a fit, and its number of columns.
  std::pair<Eigen::Index, Eigen::Index> range(size_t k) const;
  std::vector<int> all_but(const std::set<size_t>& without) const;  ///< indices of all other terms
  double price_of(const std::vector<int>& some) const;  ///< [nats] sum of the prices of these terms
  VectorXd ridge_of(const Term& t, Eigen::Index count, const VectorXd& scale) const;  ///< (count) prior precision of a term's coefficients, by the scale (n) of the residuals
  bool is_chosen(const Term& t, const std::set<size_t>& without = {}) const;  ///< true if the cause has a term here, which no second one may join
  bool shares_joint(const Term& t, const std::set<size_t>& with) const;  ///< true if t acts on a joint of one of these terms, or on several joints
  /// Columns of an entry of the dictionary. Several threads may evaluate different entries.
  const std::shared_ptr<const Columns>& columns_at(size_t k);

  struct State {
    std::vector<Chosen> terms;
    std::shared_ptr<const Rows> rows;
    Base base;
    VectorXd values;
    MatrixXd weights;
    std::vector<std::shared_ptr<const Columns>> cache;
    std::shared_ptr<const Rows> test, test_of;
    std::map<std::string, std::shared_ptr<const Columns>> test_columns;
  };
  State snapshot() const;  ///< all that restore() needs to undo later changes
  void restore(const State& s);

  /// The arm with values and the corrections of these terms.
  Model arm_of(const std::vector<Chosen>& some) const;
  /// Computes rows, base and columns at another arm; false if its rows are not the same ones.
  bool move_to(const Model& arm);
  /// Corrects the arm by steps of the k-th term, whose columns are exact at the current arm only; false if even the
  /// first step raises the score.
  bool linearise(size_t k);

  /// Fits with and without one term; the second at the arm without its correction.
  struct LeaveOneOut {
    Fitted with, fit;
    Gain gain;
    Gain on_test;  ///< gain on held-out recordings; empty if there are none
  };
  /// Function that is called at the arm without a linearised term, with the gain of the term there.
  using Visitor = std::function<void(const Round&, const Subset&, const Fitted&, double gained)>;
  LeaveOneOut evaluate_without(size_t k, const Round& now, const Visitor& visitor = {});

  /// Rows of the held-out recordings, for the current arm.
  const std::shared_ptr<const Rows>& test_rows();
  /// Residual of the held-out recordings with terms of the current set.
  MatrixXd test_residual_of(const VectorXd& x, const std::vector<int>& set);

  /// Standard parameters of the arm after a fit.
  VectorXd values_of(const Fitted& fit) const { return values_ + base_.T * fit.x.head(base_.T.cols()); }

 private:
  Base base_of(const Rows& rows) const;  ///< the arm's own columns at these rows
  bool take_step(size_t k, const std::vector<double>& step);  ///< adds to the k-th term's offset; false if the sum is impossible
  std::set<size_t> curves_beside(size_t k) const;

  const Model& arm_;
  const SearchRequest& request_;
  std::shared_ptr<const Rows> rows_;
  Folds folds_;
  Eigen::Index directions_ = 0;  // number of the arm's base parameters
  Base base_;
  VectorXd values_;
  MatrixXd weights_;
  std::vector<Term> dictionary_;
  std::vector<std::shared_ptr<const Columns>> cache_;
  std::shared_ptr<const Rows> test_, test_of_;
  std::map<std::string, std::shared_ptr<const Columns>> test_columns_;
};

}  // namespace veridyn::search
