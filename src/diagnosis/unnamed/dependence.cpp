#include "diagnosis/unnamed/dependence.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "diagnosis/evidence/numerics.hpp"
#include "math/clustered_statistics.hpp"
#include "math/student_t.hpp"

namespace veridyn {
namespace {

bool has_step(SignalKind kind) {
  return kind == SignalKind::kVelocity || kind == SignalKind::kHistory;
}

SmoothBasis basis_of(const MotionSignal& s, BasisKind kind, int intervals) {
  const double size = std::max(std::abs(s.low), std::abs(s.high));
  return {kind, s.low, s.high, intervals, size * numerics::kReversalShare};
}

class Terms {
 public:
  Terms(const std::vector<MotionSignal>& signals, int joint, const Thresholds& limits)
      : signals_(signals), joint_(joint), limits_(limits) {}

  std::vector<SmoothTerm> all() {
    for (int k = 0; k < count(); ++k) add_one(k);
    const int direction = find(SignalKind::kVelocity, joint_);
    const int own = find(SignalKind::kPosition, joint_);
    const int torque = find(SignalKind::kTorque, joint_);
    for (int k = 0; k < count() && direction >= 0; ++k) {
      if (kind(k) == SignalKind::kPosition || k == torque || kind(k) == SignalKind::kTime)
        add_on_sides(k, direction);
    }
    for (int k = 0; k < count() && own >= 0; ++k) {
      const bool other_position = kind(k) == SignalKind::kPosition && k != own;
      if (other_position || k == torque || k == direction || kind(k) == SignalKind::kTime) add_product(own, k);
    }
    // A load that is picked up during a recording, or a gain that drifts, takes a share of the torque that changes with time.
    for (int k = 0; k < count() && torque >= 0; ++k) {
      if (kind(k) == SignalKind::kTime) add_product(torque, k);
    }
    for (int k = 0; k < count() && direction >= 0; ++k) {
      if (kind(k) == SignalKind::kVelocity && k != direction) add_product(direction, k);
    }
    for (int k = 0; k < count(); ++k) {
      for (int l = k + 1; l < count(); ++l) {
        if (kind(k) == SignalKind::kPosition && kind(l) == SignalKind::kPosition && k != own &&
            l != own)
          add_product(k, l);
      }
    }
    for (int k = 0; k < count() && own >= 0; ++k) {
      if (kind(k) == SignalKind::kTorque) add_gains(k, own);
    }
    return std::move(out_);
  }

 private:
  int count() const { return static_cast<int>(signals_.size()); }
  SignalKind kind(int k) const { return signals_[k].kind; }
  bool is_own(int k) const { return signals_[k].joint == joint_; }

  int find(SignalKind kind, int joint) const {
    for (int k = 0; k < count(); ++k) {
      const MotionSignal& s = signals_[k];
      if (s.kind == kind && s.joint == joint) return k;
    }
    return -1;
  }

  double preference(const std::vector<int>& of) const {
    const bool own = std::all_of(of.begin(), of.end(), [this](int k) { return is_own(k); });
    return (own ? 1.0 : limits_.unnamed_other_joint) *
           std::pow(limits_.unnamed_two_signals, static_cast<double>(of.size() - 1));
  }

  void add_one(int k) {
    const MotionSignal& s = signals_[k];
    if (!is_own(k) && has_step(s.kind) && s.kind == SignalKind::kHistory) return;
    const BasisKind basis = has_step(s.kind) ? BasisKind::kSided : BasisKind::kSmooth;
    out_.push_back({{k}, {basis_of(s, basis, numerics::kIntervals)}, preference({k})});
  }

  void add_on_sides(int k, int direction) {
    out_.push_back({{k, direction},
                    {basis_of(signals_[k], BasisKind::kSmooth, numerics::kIntervalsOnSides),
                     basis_of(signals_[direction], BasisKind::kSides, 1)},
                    preference({k, direction})});
  }

  void add_product(int k, int l) {
    out_.push_back({{k, l},
                    {basis_of(signals_[k], BasisKind::kSmooth, numerics::kIntervalsOfTwo),
                     basis_of(signals_[l], BasisKind::kSmooth, numerics::kIntervalsOfTwo)},
                    preference({k, l})});
  }

  // Gains on a torque that vary with one position, and with the own one and another: what leans or gives way under
  // that torque turns the weight that a joint carries.
  void add_gains(int torque, int own) {
    const SmoothBasis gain = basis_of(signals_[torque], BasisKind::kProportional, 1);
    for (int k = 0; k < count(); ++k) {
      if (kind(k) != SignalKind::kPosition || (k == own && is_own(torque))) continue;
      const SmoothBasis fine = basis_of(signals_[k], BasisKind::kSmooth, numerics::kIntervalsOnSides);
      out_.push_back({{k, torque}, {fine, gain}, preference({k, torque})});
      if (k == own) continue;
      const SmoothBasis first = basis_of(signals_[own], BasisKind::kSmooth, numerics::kIntervalsOfTwo);
      const SmoothBasis second = basis_of(signals_[k], BasisKind::kSmooth, numerics::kIntervalsOfTwo);
      out_.push_back({{own, k, torque}, {first, second, gain}, preference({own, k, torque})});
    }
  }

  const std::vector<MotionSignal>& signals_;
  int joint_;
  const Thresholds& limits_;
  std::vector<SmoothTerm> out_;
};

// Usable rows of a joint, in the order of their folds.
std::vector<Eigen::Index> rows_in_folds(const MotionRows& rows, const std::vector<int>& fold, int joint) {
  std::vector<Eigen::Index> out;
  for (Eigen::Index r = 0; r < rows.residual.rows(); ++r) {
    if (rows.used(r, joint)) out.push_back(r);
  }
  std::stable_sort(out.begin(), out.end(), [&fold](Eigen::Index a, Eigen::Index b) { return fold[a] < fold[b]; });
  return out;
}

FoldedRows folded(const MotionRows& rows, const std::vector<int>& fold, int joint,
                  const std::vector<Eigen::Index>& order) {
  FoldedRows out;
  const auto count = static_cast<Eigen::Index>(order.size());
  out.signals.resize(count, rows.values.cols());
  out.response.resize(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Index r = order[k];
    out.signals.row(k) = rows.values.row(r);
    out.response[k] = rows.residual(r, joint);
    if (k == 0 || fold[r] != fold[order[k - 1]]) out.fold_begin.push_back(k);
  }
  out.fold_begin.push_back(count);
  return out;
}

// A constant is an offset, which the list has: it is no dependence.
double share_predicted(const VectorXd& residual, const VectorXd& predicted) {
  const VectorXd centred = residual.array() - residual.mean();
  VectorXd rest = residual - predicted;
  rest.array() -= rest.mean();
  const double before = centred.squaredNorm();
  return before > 0.0 ? 1.0 - rest.squaredNorm() / before : 0.0;
}

}  // namespace

std::vector<SmoothTerm> smooth_terms(const std::vector<MotionSignal>& signals, int joint,
                                     const Thresholds& limits) {
  return Terms(signals, joint, limits).all();
}

Dependence find_dependence(int joint, const MotionRows& train, const MotionRows& test,
                           const std::vector<SmoothTerm>& terms, const Thresholds& limits) {
  Dependence out;
  out.joint = joint;
  const std::vector<int> fold = folds_of(train, limits);
  const std::vector<Eigen::Index> order = rows_in_folds(train, fold, joint);
  const FoldedRows rows = folded(train, fold, joint, order);
  if (rows.fold_begin.size() < 3 || terms.empty()) return out;
  std::vector<MatrixXd> columns;
  columns.reserve(terms.size());
  for (const SmoothTerm& term : terms) columns.push_back(term.columns(rows.signals));
  const AdditiveOptions how{static_cast<int>(limits.unnamed_terms), limits.unnamed_gain, limits.tie,
                            limits.significance};
  const EstimationNumbers numbers;
  out.model = additive_regression(rows, terms, columns, how, numbers);
  const std::vector<int> fold_of_test = folds_of(test, limits);
  const std::vector<Eigen::Index> there = rows_in_folds(test, fold_of_test, joint);
  const FoldedRows of_test = folded(test, fold_of_test, joint, there);
  for (size_t k = 1; k <= out.model.chosen.size(); ++k) {
    const AdditiveModel first =
        additive_fit(rows, terms, columns,
                     {out.model.chosen.begin(), out.model.chosen.begin() + static_cast<long>(k)}, numbers);
    out.predicted_of_folds.push_back(1.0 - std::exp(-first.gain));
    out.predicted_of_test.push_back(
        of_test.response.size() == 0
            ? out.predicted_of_folds.back()
            : share_predicted(of_test.response, predicted(first, terms, of_test.signals)));
  }
  return out;
}

UnnamedShape shape_of(const Dependence& found, size_t k, const MotionRows& train,
                      const std::vector<SmoothTerm>& terms, const std::string& effort) {
  UnnamedShape out;
  out.effort = effort;
  const ChosenTerm& chosen = found.model.chosen[k];
  const SmoothTerm& term = terms[chosen.term];
  for (const int s : term.signals)
    out.signals.push_back(train.signals[s].name);
  for (const int other : chosen.as_good) {
    std::vector<std::string> names;
    for (const int s : terms[other].signals)
      names.push_back(train.signals[s].name);
    out.as_good.push_back(std::move(names));
  }
  // A grid over the signals, without the outermost hundredth; of a direction its two sides.
  const auto quantile = [&train](int column, double share) {
    std::vector<double> values(train.values.col(column).data(),
                               train.values.col(column).data() + train.values.rows());
    const auto at = values.begin() + static_cast<long>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
  };
  const bool surface = term.bases.size() > 1 && term.bases[1].kind() == BasisKind::kSmooth;
  std::vector<std::vector<double>> grids;
  for (size_t s = 0; s < term.signals.size(); ++s) {
    const SmoothBasis& basis = term.bases[s];
    std::vector<double> grid;
    const int points = surface ? numerics::kCurvePointsOfTwo : numerics::kCurvePoints;
    if (basis.kind() == BasisKind::kSides) {
      grid = {basis.low(), basis.high()};
    } else if (basis.kind() == BasisKind::kProportional) {
      grid = {std::max(std::abs(basis.low()), std::abs(basis.high()))};
    } else {
      const double low = quantile(term.signals[s], numerics::kSparseEnds);
      const double high = quantile(term.signals[s], 1.0 - numerics::kSparseEnds);
      for (int i = 0; i < points; ++i) grid.push_back(low + (high - low) * i / (points - 1));
    }
    grids.push_back(std::move(grid));
  }
  Eigen::Index rows = 1;
  for (const auto& grid : grids) rows *= static_cast<Eigen::Index>(grid.size());
  MatrixXd at = MatrixXd::Zero(rows, train.values.cols());
  Eigen::Index repeats = 1;
  for (size_t s = 0; s < grids.size(); ++s) {
    for (Eigen::Index r = 0; r < rows; ++r)
      at(r, term.signals[s]) = grids[s][(r / repeats) % grids[s].size()];
    repeats *= static_cast<Eigen::Index>(grids[s].size());
  }
  const Eigen::Index first = found.model.first_of(terms, k);
  const Eigen::RowVectorXd centre = term.columns(train.values).colwise().mean();
  const MatrixXd columns = term.columns(at).rowwise() - centre;
  const VectorXd value = columns * found.model.coefficients.segment(first, term.size());
  const MatrixXd without = columns * found.model.without.middleRows(first, term.size());
  const VectorXd deviation = jackknife_deviations(without);
  const double t = student_t_quantile(numerics::kOutside, static_cast<double>(without.cols()) - 1.0);
  for (Eigen::Index r = 0; r < at.rows(); ++r) {
    CurvePoint p;
    for (const int s : term.signals) {
      const MotionSignal& signal = train.signals[s];
      p.at.push_back(signal.kind == SignalKind::kHistory
                         ? travel_of_history(at(r, s), signal.unit_travel)
                         : at(r, s));
    }
    p.value = value[r];
    p.low = value[r] - t * deviation[r];
    p.high = value[r] + t * deviation[r];
    out.curve.push_back(std::move(p));
  }
  std::vector<MotionSignal> of;
  for (const int s : term.signals) of.push_back(train.signals[s]);
  for (const MotionSignal& s : of) out.units.push_back(s.unit);
  out.on_sides = term.bases.size() > 1 && term.bases[1].kind() == BasisKind::kSides;
  if (term.bases.back().kind() == BasisKind::kProportional) {
    const MotionSignal scaled = of.back();
    of.pop_back();
    out.words = "in proportion to " + scaled.name + ", at its largest: " + shape_words(out, of);
  } else {
    out.words = shape_words(out, of);
  }
  return out;
}

}  // namespace veridyn
