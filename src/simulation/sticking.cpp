#include "sticking.hpp"

#include <algorithm>
#include <cmath>

#include "small_cholesky.hpp"

namespace veridyn {
namespace {

constexpr int kMostSweeps = 1000;
constexpr double kConverged = 1e-13;  // change of a sweep, relative to the free acceleration
constexpr double kHolds = 1e-10;      // acceleration that still counts as none, likewise
constexpr double kDependent = 1e-9;   // share of a vector outside a span that counts as none

// Subtracts the orthonormal columns' parts from x, twice: once leaves the rounding of the first.
void take_out(const double* columns, size_t count, int n, double* x) {
  for (int pass = 0; pass < 2; ++pass) {
    for (size_t c = 0; c < count; ++c) {
      const double* column = columns + c * static_cast<size_t>(n);
      add_scaled(-dot(column, x, n), column, n, x);
    }
  }
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
      residual_(static_cast<size_t>(joints)) {
  rest_.reserve(direction_.size());
}

void Sticking::collect(const PlantForces& forces) {
  rest_.clear();
  for (int k = 0; k < forces.dry(); ++k) {
    if (direction(k) == 0) rest_.push_back(k);
  }
}

void Sticking::span(const PlantForces& forces) {
  rank_ = 0;
  for (const int k : rest_) {
    if (rank_ == static_cast<size_t>(n_)) return;
    double* column = basis(rank_);
    std::copy(forces.axis(k), forces.axis(k) + n_, column);
    const double before = std::sqrt(dot(column, column, n_));
    take_out(basis_.data(), rank_, n_, column);
    const double after = std::sqrt(dot(column, column, n_));
    if (after <= kDependent * before) continue;
    for (int i = 0; i < n_; ++i) column[i] /= after;
    ++rank_;
  }
}

void Sticking::land(const PlantForces& forces, double* dq) {
  collect(forces);
  span(forces);
  take_out(basis_.data(), rank_, n_, dq);
  for (int k = 0; k < forces.dry(); ++k) {
    if (direction(k) == 0) continue;
    std::copy(forces.axis(k), forces.axis(k) + n_, residual_.begin());
    const double before = std::sqrt(dot(residual_.data(), residual_.data(), n_));
    take_out(basis_.data(), rank_, n_, residual_.data());
    if (std::sqrt(dot(residual_.data(), residual_.data(), n_)) <= kDependent * before)
      set_direction(k, 0);
  }
}

// Projected Gauss-Seidel: each axis in turn takes the force that stops it, as far as it can.
void Sticking::solve_box(const double* y_free) {
  const double tolerance = kConverged * std::sqrt(dot(y_free, y_free, n_));
  double* y = residual_.data();
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double change = 0.0;
    for (size_t c = 0; c < rest_.size(); ++c) {
      double& lambda = lambda_[static_cast<size_t>(rest_[c])];
      const double wanted = lambda + dot(white(c), y, n_) / norms_[c];
      const double step = std::clamp(wanted, bounds_[c].lower, bounds_[c].upper) - lambda;
      if (step == 0.0) continue;
      lambda += step;
      add_scaled(-step, white(c), n_, y);
      change = std::max(change, std::abs(step) * std::sqrt(norms_[c]));
    }
    if (!(change > tolerance)) return;
  }
}

void Sticking::decide(const PlantForces& forces, const double* L, double time, const double* q,
                      double* y) {
  collect(forces);
  std::fill(decided_.begin(), decided_.end(), 0);
  const double size = std::sqrt(dot(y, y, n_));
  std::copy(y, y + n_, residual_.begin());
  for (size_t c = 0; c < rest_.size(); ++c) {
    const int k = rest_[c];
    decided_[static_cast<size_t>(k)] = 1;
    bounds_[c] = forces.at_rest(k, time, q);
    std::copy(forces.axis(k), forces.axis(k) + n_, white(c));
    solve_lower(L, n_, white(c));
    norms_[c] = dot(white(c), white(c), n_);
    double& lambda = lambda_[static_cast<size_t>(k)];
    lambda = std::clamp(lambda, bounds_[c].lower, bounds_[c].upper);
    if (!std::isfinite(lambda)) lambda = 0.0;
    add_scaled(-lambda, white(c), n_, residual_.data());
  }
  solve_box(y);
  for (size_t c = 0; c < rest_.size(); ++c) {
    const auto k = static_cast<size_t>(rest_[c]);
    const double acceleration = dot(white(c), residual_.data(), n_);
    if (std::abs(acceleration) <= kHolds * size * std::sqrt(norms_[c])) continue;
    const bool up = lambda_[k] >= bounds_[c].upper && acceleration > 0.0;
    const bool down = lambda_[k] <= bounds_[c].lower && acceleration < 0.0;
    if (!up && !down) continue;
    direction_[k] = up ? 1 : -1;
    add_scaled(-lambda_[k], white(c), n_, y);
  }
  collect(forces);
  span(forces);
  hold(L, y);
}

void Sticking::hold(const double* L, double* y) {
  const auto n = static_cast<size_t>(n_);
  size_t rank = 0;
  for (size_t c = 0; c < rank_; ++c) {
    double* column = held_.data() + rank * n;
    std::copy(basis(c), basis(c) + n_, column);
    solve_lower(L, n_, column);
    take_out(held_.data(), rank, n_, column);
    const double length = std::sqrt(dot(column, column, n_));
    for (int i = 0; i < n_; ++i) column[i] /= length;
    ++rank;
  }
  take_out(held_.data(), rank, n_, y);
}

}  // namespace veridyn
