#include "diagnosis/search/score.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "diagnosis/numerics.hpp"
#include "diagnosis/search/numbers.hpp"
#include "math/decompositions.hpp"

namespace veridyn::search {
namespace {

// Squared residuals of the rows that are used.
Eigen::ArrayXd squares_of(const VectorXd& r, const VectorXd& used) {
  return used.array() * r.array().square();
}

// Scale s of a Student-t distribution with f degrees of freedom fitted to residuals, but not below a floor: the root of
//
//   ln((f + 1) mean w),  w = r^2 / (f s^2 + r^2),
//
// in u = ln s^2, which falls with u and has the derivative mean w^2 / mean w - 1 there; by Newton's method from the rms,
// and by bisection where it would leave the bracket.
double student_scale(const Eigen::ArrayXd& squares, double count, double floor) {
  double low = std::log(floor * floor), high = std::max(low, std::log(squares.sum() / count)), u = high;
  for (int k = 0; k < kScaleSteps && high - low > kSameScale; ++k) {
    const double s2 = std::exp(u);
    double first = 0.0, second = 0.0;
    for (Eigen::Index r = 0; r < squares.size(); ++r) {
      const double w = squares[r] / (kFreedom * s2 + squares[r]);
      first += w;
      second += w * w;
    }
    const double above = std::log((kFreedom + 1.0) * first / count);
    (above > 0.0 ? low : high) = u;
    const double next = u + above / (1.0 - second / first);
    if (std::abs(next - u) < kSameScale) break;
    u = next > low && next < high ? next : 0.5 * (low + high);
  }
  return std::exp(0.5 * u);
}

// Sums over blocks of the loss ln s + (f + 1) / 2 ln(1 + r^2 / (f s^2)). The logarithms of a block's rows are
// those of their products. A row with block -1 does not count.
void add_losses(const Eigen::ArrayXd& squares, const VectorXd& used, double s, const std::vector<int>& block, Eigen::Ref<VectorXd> sums) {
  const double factor = 1.0 / (kFreedom * s * s), half = 0.5 * (kFreedom + 1.0), constant = std::log(s);
  for (Eigen::Index r = 0; r < squares.size();) {
    const int own = block[r];
    double count = 0.0, logs = 0.0;
    while (r < squares.size() && block[r] == own) {
      double product = 1.0;
      for (int k = 0; k < kLogsAtOnce && r < squares.size() && block[r] == own; ++k, ++r) {
        product *= 1.0 + factor * squares[r];
        count += used[r];
      }
      logs += std::log(product);
    }
    if (own >= 0) sums[own] += constant * count + half * logs;
  }
}

// Number of independent samples: rows over the integrated autocorrelation of a residual in order of time.
double independent_samples(const VectorXd& r, const VectorXd& used) {
  const Eigen::Index count = r.size();
  const double mean = r.dot(used) / std::max(1.0, used.sum());
  const VectorXd x = (r.array() - mean) * used.array();
  const double power = x.squaredNorm();
  if (power <= 0.0) return 0.0;
  double sum = 0.0;
  for (Eigen::Index lag = 1; lag < std::min<Eigen::Index>(kMostLags, count); ++lag) {
    const double c = x.head(count - lag).dot(x.tail(count - lag)) / power;
    if (c < kUncorrelated) break;
    sum += c;
  }
  return used.sum() / (1.0 + 2.0 * sum);
}

}  // namespace

Round::Round(const Rows& rows, const Folds& folds, const Base& base, const std::vector<SetTerm>& chosen, MatrixXd& weights)
    : rows_(rows), folds_(folds), base_(base.T.cols()), prior_(base.prior) {
  const int n = rows.joints();
  order_.resize(rows.rows());
  std::iota(order_.begin(), order_.end(), Eigen::Index{0});
  std::stable_sort(order_.begin(), order_.end(), [&](Eigen::Index a, Eigen::Index b) {
    return static_cast<unsigned>(folds.of_row[a]) < static_cast<unsigned>(folds.of_row[b]);  // borders last
  });
  begin_.assign(1, 0);
  for (int f = 0; f < folds.count; ++f) {
    Eigen::Index at = begin_.back();
    while (at < rows.rows() && folds.of_row[order_[at]] == f) ++at;
    begin_.push_back(at);
  }
  const Eigen::Index count = begin_.back();
  order_.resize(count);
  for (const Eigen::Index r : order_) block_.push_back(folds.block[r]);
  Eigen::Index p = base_;
  for (const SetTerm& c : chosen) {
    ranges_.emplace_back(p, c.columns->count());
    p += c.columns->count();
  }
  ridge_ = VectorXd::Zero(p);
  ridge_.head(base_) = base.ridge;
  for (size_t k = 0; k < chosen.size(); ++k) ridge_.segment(ranges_[k].first, ranges_[k].second) = chosen[k].ridge;
  Eigen::Index levels = 0;
  for (const SetTerm& c : chosen) levels += static_cast<Eigen::Index>(c.nonnegative.size());
  Eigen::Index next = base.value.size();
  bounds_ = MatrixXd::Zero(next + levels, p);
  value_ = VectorXd::Zero(next + levels);
  if (next > 0) bounds_.topLeftCorner(next, base_) = base.nonnegative;
  value_.head(next) = base.value;
  for (size_t k = 0; k < chosen.size(); ++k) {
    for (const Level& level : chosen[k].nonnegative) {
      value_[next] = level.own;
      bounds_(next++, ranges_[k].first + level.column) = 1.0;
    }
  }
  y_.resize(count, n);
  used_.resize(count, n);
  acting_.resize(n);
  X_.resize(n);
  for (int i = 0; i < n; ++i) {
    std::vector<const double*> from;
    const auto add = [&](const MatrixXd& columns, Eigen::Index first) {
      for (Eigen::Index c = 0; c < columns.cols(); ++c) {
        if (columns.col(c).isZero(0.0)) continue;
        acting_[i].push_back(static_cast<int>(first + c));
        from.push_back(columns.col(c).data());
      }
    };
    add(base.X[i], 0);
    for (size_t t = 0; t < chosen.size(); ++t) {
      for (size_t at = 0; at < chosen[t].columns->joints.size(); ++at) {
        if (chosen[t].columns->joints[at] == i) add(chosen[t].columns->of[at], ranges_[t].first);
      }
    }
    X_[i].resize(count, static_cast<Eigen::Index>(from.size()));
    for (size_t c = 0; c < from.size(); ++c) {
      for (Eigen::Index k = 0; k < count; ++k) X_[i](k, static_cast<Eigen::Index>(c)) = from[c][order_[k]];
    }
    for (Eigen::Index k = 0; k < count; ++k) {
      y_(k, i) = rows.residual(order_[k], i);
      used_(k, i) = rows.used(order_[k], i);
    }
  }
  rows_of_ = used_.colwise().sum().transpose();
  floor_.resize(n);
  for (int i = 0; i < n; ++i) {
    double power = 0.0;
    for (Eigen::Index k = 0; k < count; ++k) power += used_(k, i) * std::pow(rows.measured(order_[k], i), 2);
    floor_[i] = std::max(numerics::kNoise, kLeastScale * std::sqrt(power / std::max(1.0, rows_of_[i])));
    if (power == 0.0) used_.col(i).setZero();
  }
  rows_of_ = used_.colwise().sum().transpose();
  weights_ = weights.rows() == count ? weights : MatrixXd::Ones(count, n);
  MatrixXd residual = y_;
  const MatrixXd before = weights_;
  update_weights(y_);
  a_ = used_.cwiseProduct(before.cwiseSqrt()) * scale_.cwiseInverse().asDiagonal();
  std::vector<int> all(chosen.size());
  std::iota(all.begin(), all.end(), 0);
  for (int turn = 0; turn < kReweighted; ++turn) {
    compute_gram_matrices();
    const Subset s = on_all_rows(all);
    VectorXd x = s.x, none;
    within_bounds(s, *s.all, nullptr, x, none);
    for (int i = 0; i < n; ++i) residual.col(i) = y_.col(i) - X_[i] * x(acting_[i]);
    update_weights(residual);
  }
  compute_gram_matrices();
  whole_ = subset(all);
  fit_ = evaluate(whole_);
  for (int i = 0; i < n; ++i) {
    VectorXd mask = rows.used.col(i);
    for (Eigen::Index k = 0; k < rows.rows(); ++k) mask[k] *= folds.of_row[k] < 0 ? 0.0 : 1.0;
    samples_[i] = rows_of_[i] > 0.0 ? std::max(2.0, independent_samples(fit_.residual.col(i), mask)) : 0.0;
  }
  fit_.score = score_of(fit_);
  weights = weights_;
}

// Weights of the Student-t loss, and the scale of every joint, from residuals in sorted rows.
void Round::update_weights(const MatrixXd& residual) {
  const auto n = residual.cols();
  scale_.resize(n);
  samples_.resize(n);
  a_.resize(residual.rows(), n);
  weights_.resize(residual.rows(), n);
  for (Eigen::Index i = 0; i < n; ++i) {
    scale_[i] = student_scale(squares_of(residual.col(i), used_.col(i)), std::max(1.0, rows_of_[i]), floor_[i]);
    weights_.col(i) = (kFreedom + 1.0) / (kFreedom + (residual.col(i).array() / scale_[i]).square());
    VectorXd in_time = VectorXd::Zero(rows_.rows()), mask = in_time;
    for (size_t k = 0; k < order_.size(); ++k) {
      in_time[order_[k]] = residual(static_cast<Eigen::Index>(k), i);
      mask[order_[k]] = used_(static_cast<Eigen::Index>(k), i);
    }
    samples_[i] = rows_of_[i] > 0.0 ? std::max(2.0, independent_samples(in_time, mask)) : 0.0;
    const double factor = std::sqrt(samples_[i] / std::max(1.0, rows_of_[i])) / scale_[i];
    a_.col(i) = factor * used_.col(i).array() * weights_.col(i).array().sqrt();
  }
}

void Round::compute_gram_matrices() {
  const Eigen::Index p = ridge_.size();
  const int folds = folds_.count;
  G_.assign(folds, MatrixXd::Zero(p, p));
  g_.assign(folds, VectorXd::Zero(p));
  G_all_ = MatrixXd::Zero(p, p);
  g_all_ = VectorXd::Zero(p);
  for (int f = 0; f < folds; ++f) {
    const Eigen::Index first = begin_[f], count = begin_[f + 1] - first;
    for (size_t i = 0; i < X_.size(); ++i) {
      const auto a = a_.col(static_cast<Eigen::Index>(i)).segment(first, count);
      const MatrixXd A = a.asDiagonal() * X_[i].middleRows(first, count);
      const VectorXd b = a.cwiseProduct(y_.col(static_cast<Eigen::Index>(i)).segment(first, count));
      MatrixXd own = MatrixXd::Zero(A.cols(), A.cols());
      own.selfadjointView<Eigen::Lower>().rankUpdate(A.transpose());
      own.triangularView<Eigen::StrictlyUpper>() = own.transpose();
      G_[f](acting_[i], acting_[i]) += own;
      g_[f](acting_[i]) += A.transpose() * b;
    }
    G_all_ += G_[f];
    g_all_ += g_[f];
  }
}

void Round::solve(const std::vector<int>& columns, const MatrixXd& G_of_rows, const VectorXd& g, Eigen::LLT<MatrixXd>& factor, VectorXd& x) const {
  MatrixXd G = G_of_rows(columns, columns);
  G.diagonal() += ridge_(columns);
  G.diagonal().array() *= 1.0 + kGramRidge;
  G.diagonal().array() += numerics::kTiny;
  factor.compute(G);
  x = VectorXd::Zero(ridge_.size());
  const VectorXd own = factor.solve(VectorXd(g(columns)));
  x(columns) = own;
}

// The part of a subset that is fitted to all rows.
Subset Round::on_all_rows(const std::vector<int>& chosen) const {
  Subset s;
  for (Eigen::Index c = 0; c < base_; ++c) s.columns.push_back(static_cast<int>(c));
  for (const int t : chosen) {
    for (Eigen::Index c = 0; c < ranges_[t].second; ++c) s.columns.push_back(static_cast<int>(ranges_[t].first + c));
  }
  s.all = std::make_unique<Eigen::LLT<MatrixXd>>();
  solve(s.columns, G_all_, g_all_, *s.all, s.x);
  return s;
}

Subset Round::subset(const std::vector<int>& chosen) const {
  Subset s = on_all_rows(chosen);
  s.fold.resize(folds_.count);
  s.x_fold.resize(folds_.count);
  for (int f = 0; f < folds_.count; ++f) {
    if (folds_.count == 1) solve(s.columns, G_all_, g_all_, s.fold[f], s.x_fold[f]);
    else solve(s.columns, G_all_ - G_[f], g_all_ - g_[f], s.fold[f], s.x_fold[f]);
  }
  return s;
}

Cross Round::cross(const Columns& columns, const VectorXd& ridge) const {
  Cross out;
  out.columns = &columns;
  out.ridge = ridge;
  const Eigen::Index p = ridge_.size(), k = columns.count();
  for (int f = 0; f < folds_.count; ++f) {
    const Eigen::Index first = begin_[f], count = begin_[f + 1] - first;
    MatrixXd C = MatrixXd::Zero(p, k), D = MatrixXd::Zero(k, k), own(count, k), Z(count, k);
    VectorXd d = VectorXd::Zero(k);
    for (size_t at = 0; at < columns.joints.size(); ++at) {
      const int i = columns.joints[at];
      for (Eigen::Index c = 0; c < k; ++c) {
        for (Eigen::Index r = 0; r < count; ++r) {
          const double a = a_(first + r, i);
          own(r, c) = columns.of[at](order_[first + r], c);
          Z(r, c) = a * a * own(r, c);
        }
      }
      C(acting_[i], Eigen::all) += X_[i].middleRows(first, count).transpose() * Z;
      d += Z.transpose() * y_.col(i).segment(first, count);
      D.noalias() += own.transpose() * Z;
    }
    out.C.push_back(std::move(C));
    out.D.push_back(std::move(D));
    out.d.push_back(std::move(d));
  }
  return out;
}

namespace {

// Gram matrices of a further term over all folds.
struct Sums {
  MatrixXd C, D;
  VectorXd d;
};

Sums sum_over_folds(const Cross& c) {
  Sums out{c.C[0], c.D[0], c.d[0]};
  for (size_t f = 1; f < c.C.size(); ++f) {
    out.C += c.C[f];
    out.D += c.D[f];
    out.d += c.d[f];
  }
  return out;
}

}  // namespace

// The columns of a further term, eliminated next to a factored subset.
struct Round::Bordered {
  MatrixXd half;            // L^-1 C
  Eigen::LDLT<MatrixXd> S;  // factor of their Schur complement
  VectorXd z, dx;           // their coefficients, and the change of the other coefficients
  double gain = 0.0;
  bool in_span = false;

  Bordered(const Eigen::LLT<MatrixXd>& factor, const VectorXd& x, const MatrixXd& C, MatrixXd D, const VectorXd& d, const VectorXd& ridge)
      : half(factor.matrixL().solve(C)) {
    const VectorXd size = D.diagonal();
    D -= half.transpose() * half;
    z = VectorXd::Zero(d.size());
    dx = VectorXd::Zero(x.size());
    in_span = (D.diagonal().array() <= kInSpan * size.array()).all();
    if (in_span) return;
    D.diagonal() += ridge;
    D.diagonal() += kColumnRidge * size;
    D.diagonal().array() += numerics::kTiny;
    const VectorXd e = d - C.transpose() * x;
    S.compute(D);
    const VectorXd own = S.solve(e);
    in_span = !own.allFinite();
    if (in_span) return;
    z = own;
    gain = 0.5 * e.dot(z);
    dx = -factor.matrixU().solve(half * z);
  }
};

// Moves a solution to the bounds of levels that cannot be negative, by an active set: x + H^-1 A' mu with mu
// >= 0.
void Round::within_bounds(const Subset& s, const Eigen::LLT<MatrixXd>& factor, const Bordered* border, VectorXd& x, VectorXd& z) const {
  if (bounds_.rows() == 0) return;
  const MatrixXd A = bounds_(Eigen::all, s.columns);
  const VectorXd start = x(s.columns), start_z = z;
  std::vector<int> active;
  VectorXd own = start;
  for (int turn = 0; turn < kBoundTurns; ++turn) {
    const VectorXd now = A * own + value_;
    const double least = -kAtBound * (1.0 + value_.cwiseAbs().maxCoeff());
    bool grew = false;
    for (Eigen::Index k = 0; k < now.size(); ++k) {
      if (now[k] >= least || A.row(k).isZero(0.0) || std::find(active.begin(), active.end(), k) != active.end()) continue;
      active.push_back(static_cast<int>(k));
      grew = true;
    }
    if (!grew) break;
    for (;;) {
      const MatrixXd some = A(active, Eigen::all).transpose();
      MatrixXd step = factor.solve(some), step_z;
      if (border != nullptr && !border->in_span) {
        step_z = -border->S.solve(border->half.transpose() * MatrixXd(factor.matrixL().solve(some)));
        step -= factor.matrixU().solve(border->half * step_z);
      }
      MatrixXd M = some.transpose() * step;
      M.diagonal().array() *= 1.0 + kGramRidge;
      M.diagonal().array() += numerics::kTiny;
      const VectorXd mu = Eigen::LDLT<MatrixXd>(M).solve(-(A(active, Eigen::all) * start + value_(active)));
      Eigen::Index worst = 0;
      if (mu.minCoeff(&worst) < 0.0 && active.size() > 1) {
        active.erase(active.begin() + worst);
        continue;
      }
      own = start + step * mu;
      if (step_z.size() > 0) z = start_z + step_z * mu;
      break;
    }
  }
  x(s.columns) = own;
}

std::pair<MatrixXd, VectorXd> Round::normal_equations(const Subset& s, const Cross& c) const {
  const Sums all = sum_over_folds(c);
  const MatrixXd C = all.C(s.columns, Eigen::all);
  const MatrixXd half = s.all->matrixL().solve(C);
  return {all.D - half.transpose() * half, all.d - C.transpose() * VectorXd(s.x(s.columns))};
}

double Round::training_gain(const Subset& s, const Cross& c) const {
  const Sums all = sum_over_folds(c);
  const Bordered with(*s.all, VectorXd(s.x(s.columns)), MatrixXd(all.C(s.columns, Eigen::all)), all.D, all.d, c.ridge);
  return with.in_span ? -1.0 : with.gain;
}

double Round::score_of(const Fitted& fit) const { return samples_of_row().dot(fit.loss.colwise().sum()) + fit.prior; }

Fitted Round::evaluate(const Subset& s, const Cross* c) const {
  Fitted out;
  const auto n = static_cast<Eigen::Index>(X_.size());
  MatrixXd sorted = y_;
  const Eigen::Index k = c != nullptr ? c->columns->count() : 0;
  Sums all;
  if (c != nullptr) all = sum_over_folds(*c);
  for (int f = 0; f < folds_.count; ++f) {
    VectorXd x = s.x_fold[f], z = VectorXd::Zero(k);
    std::optional<Bordered> with;
    if (c != nullptr) {
      const bool one = folds_.count == 1;
      const MatrixXd C = one ? all.C : MatrixXd(all.C - c->C[f]);
      with.emplace(s.fold[f], VectorXd(x(s.columns)), MatrixXd(C(s.columns, Eigen::all)), one ? all.D : MatrixXd(all.D - c->D[f]),
                   one ? all.d : VectorXd(all.d - c->d[f]), c->ridge);
      x(s.columns) += with->dx;
      z = with->z;
    }
    within_bounds(s, s.fold[f], with ? &*with : nullptr, x, z);
    const Eigen::Index first = begin_[f], count = begin_[f + 1] - first;
    for (Eigen::Index i = 0; i < n; ++i) sorted.col(i).segment(first, count).noalias() -= X_[i].middleRows(first, count) * x(acting_[i]);
    for (size_t at = 0; c != nullptr && at < c->columns->joints.size(); ++at) {
      const int i = c->columns->joints[at];
      for (Eigen::Index r = 0; r < count; ++r) {
        double sum = 0.0;
        for (Eigen::Index e = 0; e < k; ++e) sum += c->columns->of[at](order_[first + r], e) * z[e];
        sorted(first + r, i) -= sum;
      }
    }
  }
  out.scale.resize(n);
  out.loss = MatrixXd::Zero(folds_.blocks, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::ArrayXd squares = squares_of(sorted.col(i), used_.col(i));
    out.scale[i] = student_scale(squares, std::max(1.0, rows_of_[i]), floor_[i]);
    add_losses(squares, used_.col(i), out.scale[i], block_, out.loss.col(i));
  }
  out.x = s.x;
  VectorXd z = VectorXd::Zero(k);
  std::optional<Bordered> with;
  if (c != nullptr) {
    with.emplace(*s.all, VectorXd(s.x(s.columns)), MatrixXd(all.C(s.columns, Eigen::all)), all.D, all.d, c->ridge);
    out.x(s.columns) += with->dx;
    z = with->z;
  }
  within_bounds(s, *s.all, with ? &*with : nullptr, out.x, z);
  out.x.conservativeResize(s.x.size() + k);
  out.x.tail(k) = z;
  if (prior_) out.prior = 0.5 * out.x.head(base_).squaredNorm();
  out.score = score_of(out);
  if (c != nullptr) return out;
  out.residual = MatrixXd::Zero(rows_.rows(), n);
  for (size_t r = 0; r < order_.size(); ++r) out.residual.row(order_[r]) = sorted.row(static_cast<Eigen::Index>(r));
  return out;
}

namespace {

// Gain of a set over another from the sums of their losses over blocks.
// @param weight  (n) independent samples of a row.
Gain gain_between(const Fitted& with, const Fitted& without, const VectorXd& weight, double errors) {
  Gain out;
  const MatrixXd blocks = (without.loss - with.loss) * weight.asDiagonal();
  const auto count = static_cast<double>(blocks.rows());
  const double few = std::max(1.0, count - 1.0);
  const auto scatter = [&](const VectorXd& x) { return std::sqrt((x.array() - x.mean()).square().sum() * count / few); };
  out.of_joint = blocks.colwise().sum().transpose();
  out.rise = VectorXd::Zero(weight.size());
  out.error_of_joint.resize(weight.size());
  for (Eigen::Index i = 0; i < weight.size(); ++i) {
    out.error_of_joint[i] = scatter(blocks.col(i));
    if (weight[i] == 0.0) continue;
    out.rise[i] = std::pow(with.scale[i] / without.scale[i], 2) - 1.0;
    out.share = std::max(out.share, -out.rise[i]);
  }
  out.sum = out.of_joint.sum();
  out.error = scatter(blocks.rowwise().sum());
  out.limit = errors * out.error;
  return out;
}

}  // namespace

Gain gain_on(const Rows& rows, const MatrixXd& with, const MatrixXd& without, const VectorXd& weight) {
  std::vector<int> block;
  std::map<std::pair<size_t, int>, int> known;
  for (Eigen::Index r = 0; r < rows.rows(); ++r) {
    const std::pair<size_t, int> at(rows.recording()[r], static_cast<int>(rows.time()[r] / kBlockSeconds));
    block.push_back(known.emplace(at, static_cast<int>(known.size())).first->second);
  }
  const auto fitted = [&](const MatrixXd& residual) {
    Fitted out;
    out.scale.resize(residual.cols());
    out.loss = MatrixXd::Zero(static_cast<Eigen::Index>(known.size()), residual.cols());
    for (Eigen::Index i = 0; i < residual.cols(); ++i) {
      const double least = std::max(numerics::kNoise, kLeastScale * rows.measured.col(i).norm() / std::sqrt(static_cast<double>(std::max<Eigen::Index>(1, rows.rows()))));
      const Eigen::ArrayXd squares = squares_of(residual.col(i), rows.used.col(i));
      out.scale[i] = student_scale(squares, std::max(1.0, rows.used.col(i).sum()), least);
      add_losses(squares, rows.used.col(i), out.scale[i], block, out.loss.col(i));
    }
    return out;
  };
  return gain_between(fitted(with), fitted(without), weight, kStandardErrorsWithTest);
}

Gain Round::gain(const Fitted& with, const Fitted& without) const {
  Gain out = gain_between(with, without, samples_of_row(), folds_.errors);
  out.prior = without.prior - with.prior;
  out.sum += out.prior;
  return out;
}

MatrixXd Round::covariance(const Subset& s, const Fitted& fit, const MatrixXd& M) const {
  const auto p = static_cast<Eigen::Index>(s.columns.size());
  MatrixXd scores = MatrixXd::Zero(ridge_.size(), folds_.blocks);
  for (size_t i = 0; i < X_.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const VectorXd r = (y_.col(at) - X_[i] * fit.x(acting_[i])).cwiseProduct(a_.col(at)).cwiseProduct(a_.col(at));
    MatrixXd own = MatrixXd::Zero(X_[i].cols(), folds_.blocks);
    for (Eigen::Index k = 0; k < r.size(); ++k) own.col(folds_.block[order_[k]]) += r[k] * X_[i].row(k).transpose();
    scores(acting_[i], Eigen::all) += own;
  }
  // The scatter over blocks is added to the white information, which bounds the covariance from below.
  const MatrixXd half = M * s.all->solve(MatrixXd(scores(s.columns, Eigen::all)));
  const double few = folds_.blocks / std::max(1.0, folds_.blocks - 1.0);
  MatrixXd out = few * half * half.transpose();
  const VectorXd white = (M * s.all->solve(MatrixXd::Identity(p, p))).cwiseProduct(M).rowwise().sum();
  out.diagonal() = out.diagonal().cwiseMax(white);
  return out;
}

}  // namespace veridyn::search
