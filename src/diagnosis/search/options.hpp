#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "diagnosis/search/present.hpp"

namespace veridyn::search {

/// A term that replaces others, with the score that it reaches.
struct Option {
  Term term;
  std::shared_ptr<const Columns> columns;
  VectorXd ridge;
  Fitted fit;
  double value = std::numeric_limits<double>::infinity();  ///< score with its price
  std::optional<Eigen::Vector3d> gravity;
};

/// A term that may be added to those of a round, with the products of their columns.
struct Beside {
  Term term;
  std::shared_ptr<const Columns> columns;
  Cross cross;
};

/// Compares terms in a place of the present set.
class Options {
 public:
  using Asked = std::function<bool(const Term&)>;

  Options(Present& at, const SearchRequest& request) : at_(at), request_(request) {}

  /// Products of entries of the dictionary with a round, and of other terms.
  std::vector<Beside> dictionary(const Round& round, const Asked& is_asked);
  std::vector<Beside> beside(const Round& round, const std::vector<Term>& some) const;
  /// Waves that the spectrum of a residual (rows x n) proposes.
  std::vector<Beside> ripples(const Round& round, const MatrixXd& residual) const;
  /// Gravity that points elsewhere, or that the torques do not hold: far from the file's, where no derivative leads.
  std::vector<Option> far_gravities(const Round& now, const Fitted& fit);

  /// The best terms in a place of the set, each cause once, with their shapes polished.
  /// @param needed  gain [nats]; the shapes of terms far below it are not optimised.
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
