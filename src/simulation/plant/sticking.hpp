#pragma once

#include <algorithm>
#include <vector>

#include "simulation/plant/plant_forces.hpp"

namespace veridyn {

/// Decides which directions of dry friction slide and which stick.
///
/// At rest friction is any force in an interval. Of all accelerations that such forces allow, the
/// real one solves (Gauss' least constraint with bounds; Moreau 1988 for dry friction)
///
///   minimise over lambda   | M^-1/2 (b - C lambda) |^2,   lower <= lambda <= upper
///
/// with b the other forces and C the axes at rest. The accelerations M^-1 (b - C lambda) are unique
/// even where axes depend on each other and the lambda are not. Axes whose lambda ends at a bound
/// and that accelerate begin to slide; the others are held. Vectors "whitened" are multiplied by
/// L^-1, with M = L L'.
///
/// Nothing allocates after the constructor.
class Sticking {
 public:
  explicit Sticking(const PlantForces& forces, int joints);

  /// Sliding direction of axis k: +1, -1, or 0 at rest.
  int direction(int k) const { return direction_[k]; }
  void set_direction(int k, int direction) { direction_[k] = direction; }

  /// Clears the forces of previous instants.
  void reset() { std::fill(lambda_.begin(), lambda_.end(), 0.0); }

  /// Saves the present directions for restore_directions().
  void save_directions() { kept_ = direction_; }
  void restore_directions() { direction_ = kept_; }

  /// Removes the remaining velocity along axes at rest from dq, exactly. Axes that depend on them come to rest too.
  void stop_resting_axes(double* dq);

  /// Turns the other forces b into the whitened acceleration: friction at rest is subtracted, and axes that it
  /// cannot hold get a sliding direction.
  void resolve_friction(const PlantForces& forces, const double* L, double time, const double* q, double* b);

  /// Turns the other forces into the whitened acceleration without releasing any axis: all axes at rest are
  /// held.
  void hold(const double* L, double* y);

  /// True if axis k was at rest at the last resolve_friction(), which found this force for it.
  bool was_at_rest(int k) const { return decided_[k] != 0; }
  double force(int k) const { return lambda_[k]; }  ///< [N m], [N] of axis k at rest

 private:
  void collect();  // computes rest_ and its derived members
  bool stays_at_rest(const double* held);  ///< true if friction holds all axes at rest; stores the forces of friction
  void release(const double* L, double* y);  ///< lets axes slide that cannot be held, and subtracts their forces from y
  // Computes shares_: the map from a force within the span to the smallest forces of the axes.
  void invert();
  void solve_box(const double* y_free);  ///< finds lambda_ of rest_ within bounds_
  void compute_basis();  // basis_ of the axes at rest
  int axes() const { return static_cast<int>(direction_.size()); }
  const double* axis(int k) const { return axes_.data() + k * n_; }
  double* whitened_column(size_t column) { return white_.data() + column * static_cast<size_t>(n_); }
  double* basis(size_t column) { return basis_.data() + column * static_cast<size_t>(n_); }

  int n_;
  std::vector<int> direction_, kept_;
  std::vector<int> rest_;         // axes at rest
  std::vector<Interval> bounds_;  // bounds of the forces on rest_
  std::vector<double> lambda_;    // forces of all axes, kept as the next initial guess
  std::vector<char> decided_;
  std::vector<double> white_;  // L^-1 C, columns of rest_
  std::vector<double> norms_;  // squared lengths of its columns
  std::vector<double> basis_;  // orthonormal, rank_ columns
  std::vector<double> held_;   // columns of basis_, whitened and orthonormalised
  std::vector<double> residual_;
  std::vector<double> axes_;    // C of all axes
  std::vector<double> shares_;  // pseudo-inverse of C, a column of n for each of rest_
  std::vector<double> square_;  // scratch of invert()
  std::vector<int> spanned_;    // the axes for which basis_ and shares_ hold
  std::vector<double> next_;    // forces tried by stays_at_rest()
  std::vector<double> free_;  // acceleration without friction at rest, and the force that holds it
  size_t rank_ = 0;
};

}  // namespace veridyn
