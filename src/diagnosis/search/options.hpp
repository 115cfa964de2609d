#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "diagnosis/search/present.hpp"

namespace veridyn::search {

/// A term in place of others, with the score of the changed set.
struct Option {
  Term term;
  std::shared_ptr<const Columns> columns;
  VectorXd ridge;
  Fitted fit;
  double value = std::numeric_limits<double>::infinity();  ///< score, with the price of the term
  std::optional<Eigen::Vector3d> gravity;
};

/// A term that may be added in a round, with the products of its columns and those of the round.
struct Beside {
  Term term;
  std::shared_ptr<const Columns> columns;
  Cross cross;
};

/// Compares terms at one place of the present set.
class Options {
 public:
  using Asked = std::function<bool(const Term&)>;

  Options(Present& at, const SearchRequest& request) : at_(at), request_(request) {}

  /// Products of the dictionary's entries with the columns of a round, and the other terms.
  std::vector<Beside> dictionary(const Round& round, const Asked& is_asked);
  std::vector<Beside> beside(const Round& round, const std::vector<Term>& some) const;
  /// Waves suggested by the spectrum of a residual (rows x n).
  std::vector<Beside> ripples(const Round& round, const MatrixXd& residual) const;
  /// Directions of gravity far from that of the file, and its absence: derivatives at the file's direction do
  /// not lead there.
  std::vector<Option> far_gravities(const Round& now, const Fitted& fit);

  /// The best terms at one place of the set, one of each cause, with polished shapes.
  /// @param needed  gain [nats]; terms far below it are not polished.
  std::vector<Option> best_terms(const Round& round, const Subset& s, const std::vector<Beside>& all, double needed, const Asked& is_asked) const;

  Option option(const Round& round, const Subset& s, const Term& term) const;

 private:
  static Option option(const Round& round, const Subset& s, const Beside& one);
  Beside beside(const Round& round, const Term& term, std::shared_ptr<const Columns> columns) const;
  void polish(const Round& round, const Subset& s, Option& best) const;
  void polish_load(const Round& round, const Subset& s, Option& best) const;

  Present& at_;
  const SearchRequest& request_;
};

}  // namespace veridyn::search
