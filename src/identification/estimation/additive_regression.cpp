#include "identification/estimation/additive_regression.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "math/signed_rank.hpp"

namespace veridyn {
namespace {

// Sums over the rows of one fold.
struct Sums {
  MatrixXd A;  // columns' products
  VectorXd b;  // with the response
  double y2 = 0.0;
  double rows = 0.0;
};

double mean_square(const Sums& s, const VectorXd& x) {
  return std::max(s.y2 - 2.0 * x.dot(s.b) + x.dot(s.A * x), 0.0) / std::max(s.rows, 1.0);
}

class Regression {
 public:
  Regression(const FoldedRows& rows, const std::vector<SmoothTerm>& terms,
             const std::vector<MatrixXd>& columns, const AdditiveOptions& options, const EstimationNumbers& numbers)
      : rows_(rows), terms_(terms), columns_(columns), options_(options), numbers_(numbers) {
    for (const SmoothTerm& term : terms) penalties_.push_back(term.penalty());
  }

  AdditiveModel run() {
    reset();
    while (static_cast<int>(model_.chosen.size()) < options_.most_terms && add_one()) {
    }
    drop_superfluous();
    finish();
    return std::move(model_);
  }

  AdditiveModel fit(std::vector<ChosenTerm> chosen) {
    model_.chosen = std::move(chosen);
    reset();
    finish();
    return std::move(model_);
  }

 private:
  size_t folds() const { return rows_.fold_begin.size() - 1; }
  Eigen::Index begin(size_t f) const { return rows_.fold_begin[f]; }
  Eigen::Index count(size_t f) const { return rows_.fold_begin[f + 1] - rows_.fold_begin[f]; }

  // Restarts with the columns of the constant and the chosen terms.
  void reset() {
    Eigen::Index size = 1;
    for (const ChosenTerm& c : model_.chosen) size += terms_[c.term].size();
    Z_.resize(rows_.response.size(), size);
    Z_.col(0).setOnes();
    P_ = MatrixXd::Zero(size, size);
    Eigen::Index at = 1;
    for (const ChosenTerm& c : model_.chosen) {
      const auto term = static_cast<size_t>(c.term);
      const Eigen::Index k = columns_[term].cols();
      Z_.middleCols(at, k) = columns_[term];
      P_.block(at, at, k, k) = scaled_penalty(term) * c.smoothing;
      at += k;
    }
    sums_.assign(folds(), {});
    for (size_t f = 0; f < folds(); ++f) {
      const auto Z = Z_.middleRows(begin(f), count(f));
      const auto y = rows_.response.segment(begin(f), count(f));
      sums_[f] = {Z.transpose() * Z, Z.transpose() * y, y.squaredNorm(),
                  static_cast<double>(count(f))};
    }
    before_ = held_out(sums_, P_);
  }

  MatrixXd scaled_penalty(size_t term) const {
    const double columns = columns_[term].squaredNorm();
    const double penalty = penalties_[term].trace();
    return penalty > 0.0 ? MatrixXd(penalties_[term] * (columns / penalty)) : penalties_[term];
  }

  VectorXd solve(MatrixXd A, const VectorXd& b, const MatrixXd& P) const {
    const double ridge = numbers_.ridge * std::max(A.diagonal().mean(), estimating::kLeast);
    A += P;
    A.diagonal().array() += ridge;
    return Eigen::LDLT<MatrixXd>(A).solve(b);
  }

  // Mean square of every fold, predicted from the fit to the others.
  std::vector<double> held_out(const std::vector<Sums>& sums, const MatrixXd& P) const {
    const auto [A, b, y2, rows] = total(sums);
    std::vector<double> out;
    for (size_t f = 0; f < sums.size(); ++f) {
      out.push_back(mean_square(sums[f], solve(A - sums[f].A, b - sums[f].b, P)));
    }
    return out;
  }

  static Sums total(const std::vector<Sums>& sums) {
    Sums out = sums.front();
    for (size_t f = 1; f < sums.size(); ++f) {
      out.A += sums[f].A;
      out.b += sums[f].b;
      out.y2 += sums[f].y2;
      out.rows += sums[f].rows;
    }
    return out;
  }

  // Of curves that nearly depend on each other (concurvity), each may be larger than the response
  // while they cancel: such a fit says nothing about any of them.
  bool cancels(const std::vector<Sums>& sums, const MatrixXd& P, Eigen::Index added) const {
    const Sums all = total(sums);
    const VectorXd x = solve(all.A, all.b, P);
    const double response = all.y2 - all.b[0] * all.b[0] / all.rows;
    Eigen::Index at = 1;
    for (size_t k = 0; k <= model_.chosen.size(); ++k) {
      const Eigen::Index size = k < model_.chosen.size() ? terms_[model_.chosen[k].term].size() : added;
      const auto own = x.segment(at, size);
      const double sum = all.A.row(0).segment(at, size).dot(own);
      if (own.dot(all.A.block(at, at, size, size) * own) - sum * sum / all.rows > numbers_.largest * response) return true;
      at += size;
    }
    return false;
  }

  struct Try {
    int term = -1;
    double smoothing = 0.0;
    double gain = -1.0;
    std::vector<double> falls;
  };

  std::vector<double> falls_to(const std::vector<double>& after) const {
    std::vector<double> out;
    for (size_t f = 0; f < after.size(); ++f)
      out.push_back(std::log(std::max(before_[f], estimating::kLeast)) - std::log(std::max(after[f], estimating::kLeast)));
    return out;
  }

  static double mean(const std::vector<double>& v) {
    double sum = 0.0;
    for (const double x : v) sum += x;
    return sum / static_cast<double>(v.size());
  }

  Try attempt(int term) const {
    const MatrixXd& C = columns_[term];
    const Eigen::Index m = Z_.cols();
    const Eigen::Index k = C.cols();
    std::vector<Sums> sums(folds());
    for (size_t f = 0; f < folds(); ++f) {
      const auto own = C.middleRows(begin(f), count(f));
      Sums& s = sums[f];
      s.A.resize(m + k, m + k);
      s.A.topLeftCorner(m, m) = sums_[f].A;
      s.A.topRightCorner(m, k) = Z_.middleRows(begin(f), count(f)).transpose() * own;
      s.A.bottomLeftCorner(k, m) = s.A.topRightCorner(m, k).transpose();
      s.A.bottomRightCorner(k, k) = own.transpose() * own;
      s.b.resize(m + k);
      s.b << sums_[f].b, own.transpose() * rows_.response.segment(begin(f), count(f));
      s.y2 = sums_[f].y2;
      s.rows = sums_[f].rows;
    }
    std::vector<Try> tries;
    const MatrixXd own_penalty = scaled_penalty(static_cast<size_t>(term));
    double smoothing = numbers_.least_smoothing;
    for (int s = 0; s < numbers_.smoothings; ++s, smoothing *= numbers_.smoothing_step) {
      MatrixXd P = MatrixXd::Zero(m + k, m + k);
      P.topLeftCorner(m, m) = P_;
      P.bottomRightCorner(k, k) = smoothing * own_penalty;
      if (cancels(sums, P, k)) continue;
      const std::vector<double> falls = falls_to(held_out(sums, P));
      tries.push_back({term, smoothing, mean(falls), falls});
      if (own_penalty.isZero(0.0)) break;
    }
    if (tries.empty()) return {};
    // Chooses the smoothest of those with nearly the largest gain.
    double most = tries.front().gain;
    for (const Try& t : tries) most = std::max(most, t.gain);
    const auto smoothest = std::find_if(tries.rbegin(), tries.rend(), [this, most](const Try& t) {
      return t.gain >= most - numbers_.as_smooth * std::abs(most);
    });
    return *smoothest;
  }

  bool passes(const Try& t) const {
    return t.gain > options_.smallest_gain &&
           (static_cast<size_t>(std::count_if(t.falls.begin(), t.falls.end(),
                                              [](double d) { return d > 0.0; })) == t.falls.size() ||
            signed_rank_p_value(t.falls) <= options_.significance);
  }

  bool add_one() {
    std::vector<Try> good;
    for (int k = 0; k < static_cast<int>(terms_.size()); ++k) {
      const bool taken =
          std::any_of(model_.chosen.begin(), model_.chosen.end(),
                      [k](const ChosenTerm& c) { return c.term == k; });
      if (taken) continue;
      Try t = attempt(k);
      if (passes(t)) good.push_back(std::move(t));
    }
    if (good.empty()) return false;
    const auto worth = [this](const Try& t) {
      return t.gain * terms_[t.term].preference;
    };
    const auto best = std::max_element(good.begin(), good.end(), [&](const Try& a, const Try& b) {
      return worth(a) < worth(b);
    });
    model_.chosen.push_back({best->term, best->smoothing, best->gain});
    reset();
    return true;
  }

  // Drops a term without which the held-out error is no larger.
  void drop_superfluous() {
    for (size_t k = model_.chosen.size(); k-- > 0 && model_.chosen.size() > 1;) {
      const std::vector<double> with = before_;
      const ChosenTerm own = model_.chosen[k];
      model_.chosen.erase(model_.chosen.begin() + static_cast<long>(k));
      reset();
      double loss = 0.0;
      for (size_t f = 0; f < with.size(); ++f)
        loss += std::log(std::max(before_[f], estimating::kLeast)) - std::log(std::max(with[f], estimating::kLeast));
      if (loss / static_cast<double>(with.size()) < options_.smallest_gain) continue;
      model_.chosen.insert(model_.chosen.begin() + static_cast<long>(k), own);
      reset();
    }
  }

  void finish() {
    const std::vector<double> after = held_out(sums_, P_);
    const std::vector<ChosenTerm> chosen = std::move(model_.chosen);
    const Sums all = total(sums_);
    model_.coefficients = solve(all.A, all.b, P_);
    model_.chosen.clear();
    reset();  // gains are relative to the model with a constant alone
    model_.falls = falls_to(after);
    model_.gain = mean(model_.falls);
    model_.chosen = chosen;
  }

  const FoldedRows& rows_;
  const std::vector<SmoothTerm>& terms_;
  const std::vector<MatrixXd>& columns_;
  const AdditiveOptions& options_;
  const EstimationNumbers& numbers_;
  std::vector<MatrixXd> penalties_;
  AdditiveModel model_;
  MatrixXd Z_, P_;
  std::vector<Sums> sums_;
  std::vector<double> before_;
};

}  // namespace

Eigen::Index SmoothTerm::size() const {
  Eigen::Index out = 1;
  for (const SmoothBasis& basis : bases) out *= basis.size();
  return out;
}

MatrixXd SmoothTerm::columns(const MatrixXd& x) const {
  MatrixXd out(x.rows(), size());
  VectorXd product(size());
  VectorXd factor;
  for (Eigen::Index r = 0; r < x.rows(); ++r) {
    product[0] = 1.0;
    Eigen::Index so_far = 1;
    for (size_t b = 0; b < bases.size(); ++b) {
      factor.resize(bases[b].size());
      bases[b].values(x(r, signals[b]), factor.data());
      for (Eigen::Index k = factor.size(); k-- > 0;)  // from the last: the first block is overwritten last
        product.segment(k * so_far, so_far) = factor[k] * product.head(so_far);
      so_far *= factor.size();
    }
    out.row(r) = product.transpose();
  }
  return out;
}

MatrixXd SmoothTerm::penalty() const {
  MatrixXd out = MatrixXd::Zero(size(), size());
  Eigen::Index inside = 1;
  for (const SmoothBasis& basis : bases) {
    const MatrixXd own = basis.penalty();
    const Eigen::Index block = own.rows() * inside;
    for (Eigen::Index first = 0; first < out.rows(); first += block) {
      for (Eigen::Index a = 0; a < own.rows(); ++a) {
        for (Eigen::Index b = 0; b < own.rows(); ++b)
          out.block(first + a * inside, first + b * inside, inside, inside).diagonal().array() += own(a, b);
      }
    }
    inside = block;
  }
  return out;
}

Eigen::Index AdditiveModel::first_of(const std::vector<SmoothTerm>& terms, size_t k) const {
  Eigen::Index at = 1;
  for (size_t i = 0; i < k; ++i) at += terms[chosen[i].term].size();
  return at;
}

AdditiveModel additive_regression(const FoldedRows& rows, const std::vector<SmoothTerm>& terms,
                                  const std::vector<MatrixXd>& columns, const AdditiveOptions& options,
                                  const EstimationNumbers& numbers) {
  return Regression(rows, terms, columns, options, numbers).run();
}

AdditiveModel additive_fit(const FoldedRows& rows, const std::vector<SmoothTerm>& terms,
                           const std::vector<MatrixXd>& columns, std::vector<ChosenTerm> chosen,
                           const EstimationNumbers& numbers) {
  const AdditiveOptions none{};
  return Regression(rows, terms, columns, none, numbers).fit(std::move(chosen));
}

VectorXd predicted(const AdditiveModel& model, const std::vector<SmoothTerm>& terms,
                   const MatrixXd& signals) {
  VectorXd out = VectorXd::Constant(signals.rows(), model.coefficients[0]);
  for (size_t k = 0; k < model.chosen.size(); ++k) {
    const SmoothTerm& term = terms[model.chosen[k].term];
    out += term.columns(signals) *
           model.coefficients.segment(model.first_of(terms, k), term.size());
  }
  return out;
}

}  // namespace veridyn
