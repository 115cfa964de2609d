#include "simulation/plant/sticking.hpp"

#include <algorithm>
#include <cmath>

#include "simulation/plant/small_cholesky.hpp"

namespace veridyn {
namespace {

constexpr int kMostSweeps = 1000;
constexpr double kConverged = 1e-13;  // largest change per sweep, relative to the free acceleration
constexpr double kHolds = 1e-10;      // relative acceleration that counts as zero
// Relative remainder of a vector outside a span that counts as zero.
constexpr double kDependent = 1e-9;

// Subtracts the components of x along orthonormal columns.
void subtract_components_once(const double* columns, size_t count, int n, double* x) {
  for (size_t c = 0; c < count; ++c) {
    const double* column = columns + c * static_cast<size_t>(n);
    add_scaled(-dot(column, x, n), column, n, x);
  }
}

// Subtracts the components in two passes, since one leaves rounding errors.
void subtract_components(const double* columns, size_t count, int n, double* x) {
  subtract_components_once(columns, count, n, x);
  subtract_components_once(columns, count, n, x);
}

}  // namespace

Sticking::Sticking(const PlantForces& forces, int joints)
    : n_(joints),
      direction_(static_cast<size_t>(forces.dry()), 0),
      kept_(direction_),
      bounds_(direction_.size()),
      lambda_(direction_.size(), 0.0),
      decided_(direction_.size(), 0),
      white_(direction_.size() * static_cast<size_t>(joints)),
      norms_(direction_.size()),
      basis_(static_cast<size_t>(joints) * static_cast<size_t>(joints)),
      held_(basis_.size()),
      residual_(static_cast<size_t>(joints)),
      axes_(white_.size()),
      shares_(white_.size()),
      square_(basis_.size()),
      next_(direction_.size()),
      free_(static_cast<size_t>(joints)) {
  rest_.reserve(direction_.size());
  spanned_.reserve(direction_.size());
  for (int k = 0; k < forces.dry(); ++k)
    std::copy(forces.axis(k), forces.axis(k) + n_, axes_.begin() + k * n_);
}

void Sticking::collect() {
  rest_.clear();
  for (int k = 0; k < axes(); ++k) {
    if (direction(k) == 0) rest_.push_back(k);
  }
  if (rest_ == spanned_) return;
  spanned_ = rest_;
  compute_basis();
  invert();
}

void Sticking::compute_basis() {
  rank_ = 0;
  for (const int k : rest_) {
    if (rank_ == static_cast<size_t>(n_)) return;
    double* column = basis(rank_);
    std::copy(axis(k), axis(k) + n_, column);
    const double before = std::sqrt(dot(column, column, n_));
    subtract_components(basis_.data(), rank_, n_, column);
    const double after = std::sqrt(dot(column, column, n_));
    if (after <= kDependent * before) continue;
    for (int i = 0; i < n_; ++i) column[i] /= after;
    ++rank_;
  }
}

void Sticking::stop_resting_axes(double* dq) {
  collect();
  if (rank_ == 0) return;
  subtract_components(basis_.data(), rank_, n_, dq);
  for (int k = 0; k < axes(); ++k) {
    if (direction(k) == 0) continue;
    std::copy(axis(k), axis(k) + n_, residual_.begin());
    const double before = std::sqrt(dot(residual_.data(), residual_.data(), n_));
    subtract_components(basis_.data(), rank_, n_, residual_.data());
    if (std::sqrt(dot(residual_.data(), residual_.data(), n_)) <= kDependent * before)
      set_direction(k, 0);
  }
}

// Solves by projected Gauss-Seidel: each axis in turn gets the force that stops it, within its bounds.
void Sticking::solve_box(const double* y_free) {
  const double tolerance = kConverged * std::sqrt(dot(y_free, y_free, n_));
  double* y = residual_.data();
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double change = 0.0;
    for (size_t c = 0; c < rest_.size(); ++c) {
      double& lambda = lambda_[rest_[c]];
      const double wanted = lambda + dot(whitened_column(c), y, n_) / norms_[c];
      const double step = std::clamp(wanted, bounds_[c].lower, bounds_[c].upper) - lambda;
      if (step == 0.0) continue;
      lambda += step;
      add_scaled(-step, whitened_column(c), n_, y);
      change = std::max(change, std::abs(step) * std::sqrt(norms_[c]));
    }
    if (!(change > tolerance)) return;
  }
}

// Computes the pseudo-inverse C+ = R' (R R')^-1 Q' of the axes C = Q R at rest, where Q is the basis.
void Sticking::invert() {
  const auto n = static_cast<size_t>(n_);
  const auto rank = static_cast<int>(rank_);
  const auto at = [&](int i, int j) { return static_cast<size_t>(i + j * rank); };
  for (int i = 0; i < rank; ++i) {
    for (int j = 0; j < rank; ++j) {
      double sum = 0.0;
      for (size_t c = 0; c < rest_.size(); ++c)
        sum += dot(basis(static_cast<size_t>(i)), axis(rest_[c]), n_) *
               dot(basis(static_cast<size_t>(j)), axis(rest_[c]), n_);
      square_[at(i, j)] = sum;
    }
  }
  cholesky_in_place(square_.data(), rank);
  for (size_t c = 0; c < rest_.size(); ++c) {
    for (int i = 0; i < rank; ++i)
      residual_[i] = dot(basis(static_cast<size_t>(i)), axis(rest_[c]), n_);
    solve_lower(square_.data(), rank, residual_.data());
    solve_lower_transposed(square_.data(), rank, residual_.data());
    double* share = shares_.data() + c * n;
    std::fill(share, share + n, 0.0);
    for (int i = 0; i < rank; ++i)
      add_scaled(residual_[i], basis(static_cast<size_t>(i)), n_, share);
  }
}

// True if forces within the bounds hold all axes at rest; these are the previous forces plus the smallest
// sufficient change. Most calls at rest end here.
//
// @param held  total force on the axes, including the inertia of the others.
bool Sticking::stays_at_rest(const double* held) {
  std::copy(held, held + n_, residual_.begin());
  for (const int k : rest_)
    add_scaled(-lambda_[k], axis(k), n_, residual_.data());
  for (size_t c = 0; c < rest_.size(); ++c) {
    next_[c] = lambda_[rest_[c]] +
               dot(shares_.data() + c * static_cast<size_t>(n_), residual_.data(), n_);
    if (!(next_[c] >= bounds_[c].lower && next_[c] <= bounds_[c].upper)) return false;
  }
  for (size_t c = 0; c < rest_.size(); ++c) lambda_[rest_[c]] = next_[c];
  return true;
}

void Sticking::resolve_friction(const PlantForces& forces, const double* L, double time, const double* q,
                      double* b) {
  std::fill(decided_.begin(), decided_.end(), 0);
  collect();
  if (rest_.empty()) {
    solve_lower(L, n_, b);
    return;
  }
  for (size_t c = 0; c < rest_.size(); ++c) {
    decided_[rest_[c]] = 1;
    bounds_[c] = forces.at_rest(rest_[c], time, q);
  }
  solve_lower(L, n_, b);
  std::copy(b, b + n_, free_.begin());
  hold(L, b);
  for (int i = 0; i < n_; ++i) free_[i] -= b[i];
  multiply_lower(L, n_, free_.data());
  if (stays_at_rest(free_.data())) return;
  solve_lower(L, n_, free_.data());
  for (int i = 0; i < n_; ++i) b[i] += free_[i];
  release(L, b);
  hold(L, b);
}

// Finds the axes that cannot be held, and subtracts their forces from y.
void Sticking::release(const double* L, double* y) {
  const double size = std::sqrt(dot(y, y, n_));
  std::copy(y, y + n_, residual_.begin());
  for (size_t c = 0; c < rest_.size(); ++c) {
    const int k = rest_[c];
    std::copy(axis(k), axis(k) + n_, whitened_column(c));
    solve_lower(L, n_, whitened_column(c));
    norms_[c] = dot(whitened_column(c), whitened_column(c), n_);
    double& lambda = lambda_[k];
    lambda = std::clamp(lambda, bounds_[c].lower, bounds_[c].upper);
    if (!std::isfinite(lambda)) lambda = 0.0;
    add_scaled(-lambda, whitened_column(c), n_, residual_.data());
  }
  solve_box(y);
  for (size_t c = 0; c < rest_.size(); ++c) {
    const auto k = static_cast<size_t>(rest_[c]);
    const double acceleration = dot(whitened_column(c), residual_.data(), n_);
    if (std::abs(acceleration) <= kHolds * size * std::sqrt(norms_[c])) continue;
    const bool up = lambda_[k] >= bounds_[c].upper && acceleration > 0.0;
    const bool down = lambda_[k] <= bounds_[c].lower && acceleration < 0.0;
    if (!up && !down) continue;
    direction_[k] = up ? 1 : -1;
    add_scaled(-lambda_[k], whitened_column(c), n_, y);
  }
  collect();
}

void Sticking::hold(const double* L, double* y) {
  const auto n = static_cast<size_t>(n_);
  for (size_t c = 0; c < rank_; ++c) {
    double* column = held_.data() + c * n;
    std::copy(basis(c), basis(c) + n_, column);
    solve_lower(L, n_, column);
    subtract_components_once(held_.data(), c, n_, column);
    const double inverse = 1.0 / std::sqrt(dot(column, column, n_));
    for (int i = 0; i < n_; ++i) column[i] *= inverse;
  }
  if (rank_ == n) {
    std::fill(y, y + n_, 0.0);
    return;
  }
  subtract_components(held_.data(), rank_, n_, y);
}

}  // namespace veridyn
