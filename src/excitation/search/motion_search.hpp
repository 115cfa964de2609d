#pragma once


#include "excitation/limits/limit_signals.hpp"
#include "excitation/search/motion_space.hpp"
#include "excitation/search/question.hpp"
#include "excitation/search/search_program.hpp"
#include "excitation/search/search_progress.hpp"

namespace veridyn {

/// Number of descents of one search for the condition number, each with a sharper approximation.
constexpr int kStages = 2;

/// Result of one start.
struct Found {
  std::vector<VectorXd> ends;  ///< final points of its descents; empty: no motion within the limits
  bool converged = false;      ///< the last descent converged
  long evaluations = 0;
  VectorXd start;    ///< the first random motion
  VectorXd nearest;  ///< the motion with the smallest violation, if none is within the limits
};

/// The searches of one problem; each start is independent. Immutable: starts run in parallel.
class MotionSearch {
 public:
  MotionSearch(const MotionSpace& space, const LimitSignals& signals, const Question& question,
               const ExcitationOptions& options, const NonlinearSolver& solver,
               SearchProgress& progress);

  Found run(int start) const;  ///< searches from start 0, 1, ...

  /// Approximate number of iterations of one start, without repeated descents.
  static int expected_iterations(const ExcitationOptions& options);

  /// Makes a final descent on a close approximation of the condition number. Returns an empty vector for other
  /// criteria, or if it finds no motion within the limits.
  VectorXd polished(const VectorXd& from, int start, Found& found) const;

  /// The best motion near `from` in which each of the joints uses kLittleUse of its range within `limits`.
  /// Empty if none is found.
  VectorXd widened(const VectorXd& from, const std::vector<int>& joints, const MotionLimits& limits, Found& found) const;

 private:
  struct Bounds {
    VectorXd lower, upper;  ///< bounds of every signal
  };
  Bounds signal_bounds() const;  ///< limits of all signals; torques with a margin
  bool has_more_than_joints() const { return signals_.count() > 3 * space_.joints(); }  ///< limits beyond those of the joints
  double smooth_cost(const VectorXd& x, double sharpness) const;  ///< differentiable criterion
  bool is_within(const VectorXd& x, const Bounds& bounds) const;  ///< true: x is within the limits at all instants
  using Spans = std::vector<GridConstraints::Span>;
  struct Descent {
    double sharpness;
    int iterations;
    Spans spans{};
  };
  std::vector<VectorXd> drawn_starts(int start, const Bounds& bounds, Found& found) const;  ///< random starting points, the best first
  std::vector<VectorXd> best_descents(const std::vector<VectorXd>& from, const Bounds& bounds, int start,
                              Found& found) const;  ///< ends of trial descents, the best first; if all fail, from.front()
  VectorXd track_minimum(VectorXd x, int start, Found& found) const;  ///< descends with increasing sharpness; the last result within the limits, or empty
  VectorXd descend(const VectorXd& from, const Bounds& bounds, const Descent& descent, int start,
                   Found& found) const;
  VectorXd projected_into_limits(const VectorXd& from, const Bounds& bounds) const;
  bool tighten_bounds(const VectorXd& x, Bounds& bounds) const;  ///< by the violations of x between grid instants; false: x has none

  const MotionSpace& space_;
  const LimitSignals& signals_;
  const Question& question_;
  const ExcitationOptions& options_;
  const NonlinearSolver& solver_;
  SearchProgress& progress_;
};

/// optimise_excitation() of excitation.hpp, with any solver in place of the interior point.
Excitation optimise_excitation(const Model& arm, const ExcitationOptions& options,
                               const NonlinearSolver& solver);

/// The motion of the same shape within the ranges, speeds and accelerations of the space: joints that exceed
/// one of them are scaled down and shifted.
VectorXd fitted_to_joints(const MotionSpace& space, const VectorXd& x);

/// Range and margin of every limit along a motion, between instants as well: for joints by rigorous bounds,
/// for others by their curvature at 64 instants of the shortest period.
std::vector<LimitMargin> limit_margins(const LimitSignals& signals,
                                       const FourierTrajectory& trajectory);

/// Range and margin of every limit for samples of a motion that need not repeat, by the curvature between them.
std::vector<LimitMargin> limit_margins(const LimitSignals& signals, const MotionSamples& motion);

/// The margins of two motions that follow each other.
std::vector<LimitMargin> joined(const std::vector<LimitMargin>& first,
                                const std::vector<LimitMargin>& second);

}  // namespace veridyn
