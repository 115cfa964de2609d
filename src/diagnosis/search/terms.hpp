#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "diagnosis/candidates.hpp"
#include "diagnosis/search/rows.hpp"
#include "identification/estimation/smooth_basis.hpp"
#include "effects/kinematic_error.hpp"

namespace veridyn::search {

/// Kind of a term: determines its columns, and how its finding changes the arm.
enum class TermKind {
  kEffect,    ///< an effect along an axis
  kChange,    ///< a change of the level of an effect that the MODEL has
  kChannel,   ///< an error of a recorded signal, or of the arm as a whole
  kConstant,  ///< a constant of the robot file
  kLoad,      ///< a load on a frame, with a mass of either sign
  kCurve,     ///< a smooth function of signals, without a name
};

/// A shape constant of a term, in which the torque is nonlinear, and the range of its search.
struct TermShape {
  std::string name;
  double lower, upper;
  bool logarithmic;
  double step;  ///< half of the distance to the next value of the grid: a factor, or a difference
  bool fixed;   ///< not polished
};

/// A signal that a curve depends on.
enum class SignalKind { kPosition, kVelocity, kTorque, kHistory, kTime };
struct Signal {
  SignalKind kind = SignalKind::kPosition;
  int joint = 0;
  std::string name;  ///< "q1", "dq1", "tau1", "history1", "t"
  std::string unit;
  double low = 0.0, high = 0.0;  ///< range in the recordings
};

/// One entry of the dictionary: a cause at a place (a joint, a frame or the whole arm), its shape constants and its price.
/// A curve has signals in place of a cause.
struct Term {
  TermKind kind = TermKind::kEffect;
  Candidate candidate;       ///< set for all terms but constants and curves
  Cause cause;
  std::optional<JointIndex> joint;  ///< joint on which it acts; empty if it acts on several
  std::string place;         ///< cause as text: terms with the same place differ in their shapes only
  EffectTerm effect;         ///< effect with its shape constants as values
  std::vector<TermShape> shapes;
  std::optional<FrameConstant> constant;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< centre of a load, about which its inertia is that of a point
  double mass = 0.0;         ///< [kg] mass of that load; 0: not fitted yet
  std::vector<Signal> signals;
  std::vector<SmoothBasis> bases;
  double price = 0.0;        ///< ln 1/prior, with the prices of its grid and of its polished constants
  bool is_daily = false;     ///< a change of a level that differs from day to day: the MODEL's prior is its price
  bool with_rest = false;    ///< the term has one more parameter, the position at which a spring has no torque
  bool imitates = false;     ///< the term can imitate many other causes, see Effect::imitates_others()
  std::vector<Level> nonnegative;  ///< parameters that cannot be negative
  VectorXd largest;          ///< largest plausible size of each parameter; empty: unlimited

  /// True if its columns are derivatives at the current arm.
  bool is_linearised() const { return kind == TermKind::kChannel || kind == TermKind::kConstant; }
};

/// True if two terms are the same cause with different shapes.
bool same_place(const Term& a, const Term& b);

/// The terms to test.
struct TermScope {
  bool changes = false;
  bool constants = true;            ///< constants of the robot file
  std::vector<std::string> wanted;  ///< effects or causes as text; empty: all
  std::set<int> silent;             ///< joints on which nothing is tested
  bool poses = false;               ///< the rows are poses at rest

  bool is_wanted(const Model& arm, const Cause& cause) const;
};

/// Largest change of a constant of the robot file: an optimum beyond it is rejected.
double largest_change_of(const FrameConstant& constant);

/// The dictionary of an arm, with prices.
std::vector<Term> dictionary(const Rows& rows, const TermScope& scope);

/// Ripples suggested by the spectrum of a residual (rows x n) over the positions.
std::vector<Term> ripples(const Rows& rows, const MatrixXd& residual, const std::vector<Term>& all, int threads);

/// Inertial parameters of a load by its coefficients: mass and first moments, with the inertia of a point mass linearised
/// at a centre, then the inertia beyond that.
Eigen::Matrix<double, 10, 10> load_parameters(const Eigen::Vector3d& centre);

/// Columns of a term at the rows, for its shape constants and the arm of the rows.
Columns columns_of(const Term& term, const Rows& rows);

/// The arm after a step of a linearised term.
Model with_step(const Model& arm, const Term& term, const std::vector<double>& step);

/// Values of a signal along a stretch.
VectorXd signal_along(const Signal& signal, const Stretch& stretch, double rest_speed);

/// Values of a curve's columns.
MatrixXd curve_columns(const Term& term, const MatrixXd& signals);

}  // namespace veridyn::search
