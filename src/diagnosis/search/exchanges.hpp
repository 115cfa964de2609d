#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "diagnosis/search/current_set.hpp"

namespace veridyn::search {

/// A change of the current set: one term takes the place of others. It has the score of the changed set.
struct Exchange {
  Term term;
  std::shared_ptr<const Columns> columns;
  VectorXd ridge;
  Fitted fit;
  double value = std::numeric_limits<double>::infinity();  ///< score, with the price of the term
  std::optional<Eigen::Vector3d> gravity;
};

/// The products of a term's columns with those of a round, from which its gain in the round is computed.
struct TermProducts {
  Term term;
  std::shared_ptr<const Columns> columns;
  Cross cross;
};

/// Evaluates exchanges of terms of the current set for terms of the dictionary.
class Exchanges {
 public:
  /// True for the terms that are compared.
  using TermFilter = std::function<bool(const Term&)>;

  Exchanges(CurrentSet& at, const SearchRequest& request) : current_(at), request_(request) {}

  /// Products of the selected entries of the dictionary with the columns of a round.
  std::vector<TermProducts> products_of_dictionary(const Round& round, const TermFilter& is_selected);
  std::vector<TermProducts> products_of(const Round& round, const std::vector<Term>& some) const;
  /// Products of waves that the spectrum of a residual (rows x n) suggests.
  std::vector<TermProducts> products_of_ripples(const Round& round, const MatrixXd& residual) const;
  /// Exchanges for directions of gravity far from that of the file, and for its absence: derivatives at the
  /// file's direction do not lead there.
  std::vector<Exchange> far_gravities(const Round& now, const Fitted& fit);

  /// The exchanges with the lowest scores that add a term to s: one of each cause, with polished shapes.
  /// @param needed  required gain [nats]; terms far below it are not polished.
  std::vector<Exchange> best_terms(const Round& round, const Subset& s, const std::vector<TermProducts>& all, double needed, const TermFilter& is_selected) const;

  /// The set s with one more term. Its value stays infinite if the coefficients have an impossible sign.
  Exchange exchange_with(const Round& round, const Subset& s, const Term& term) const;

 private:
  static Exchange exchange_with(const Round& round, const Subset& s, const TermProducts& one);
  TermProducts products_of(const Round& round, const Term& term, std::shared_ptr<const Columns> columns) const;
  void polish_shapes(const Round& round, const Subset& s, Exchange& best) const;
  void polish_load(const Round& round, const Subset& s, Exchange& best) const;

  CurrentSet& current_;
  const SearchRequest& request_;
};

}  // namespace veridyn::search
