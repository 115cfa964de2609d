#pragma once

#include <memory>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"
#include "veridyn/simulation/engine.hpp"

namespace veridyn {

/// Accuracy and limits of a Plant.
struct PlantOptions {
  /// A substep is taken if its estimated error of every q and dq h is below tolerance * (|dq| h +
  /// rest), with the estimate of order three for a method of order four.
  double tolerance = 1e-6;
  double rest = 1e-6;        ///< [rad] or [m]; what the error may be at standstill
  int most_substeps = 2000;  ///< Largest number of substeps of one step
};

/// Forward dynamics of an arm with all its effects:
///
///   M(q) ddq + C(q, dq) dq + g(q) + effects = tau
///
/// Nystroem's method of order four for second-order equations (Hairer, Norsett and Wanner, Solving
/// ODEs I, 1993, ch. II.14; an estimate of order three as in ch. II.4), as many substeps as the
/// error asks for. Its two stages in the middle of a substep stand at one position: where the arm
/// is small enough for a processor's vectors, the second one costs next to nothing.
///
/// Dry friction (Coulomb, Stribeck, asymmetric, load- and position-dependent, ...) is what it is in
/// nature: at rest it takes any value up to its level, so that a joint that stands stands still for
/// ever, and one that slides changes its direction exactly where its velocity is zero (the substep
/// ends there). Which axes stick and which begin to slide is the solution of Gauss' principle of
/// least constraint with bounds on the friction forces, unique in the accelerations for any number
/// of coupled axes. Below kRestSpeed the regularised sign of the effects is *not* used; from there
/// on the forces are those of the effects. Friction with a memory runs along the true path:
/// substeps end where its axis turns round.
///
/// Effects that describe measured motion only (transmission_compliance) are left out, see
/// left_out().
///
/// Allocates in the constructor alone. One object serves one thread.
class Plant final : public Engine {
 public:
  /// @throws InvalidInput  a body or an effect has no values; the mass matrix is not positive
  ///                       definite somewhere in the joints' range, or friction drives the motion
  ///                       there: the message names the configuration.
  explicit Plant(const Model& arm, const PlantOptions& options = {});
  ~Plant() override;
  Plant(Plant&&) noexcept;
  Plant& operator=(Plant&&) noexcept;

  int joints() const override;
  void set_state(const VectorRef& q, const VectorRef& dq) override;
  StepStatus step(const VectorRef& tau, double dt) noexcept override;
  StepStatus accelerate(const VectorRef& tau, VectorXd& ddq) noexcept override;
  double time() const override;
  const VectorXd& q() const override;
  const VectorXd& dq() const override;
  int failed_joint() const override;

  /// Torques of all effects at the last instant that was evaluated, friction at rest included, (n):
  /// tau = M ddq + C dq + g + these.
  const VectorXd& effect_torques() const;

  /// Substeps taken and refused since set_state().
  struct Work {
    long taken = 0;
    long refused = 0;
  };
  Work work() const;

  /// Effects of the model that a forward simulation cannot have, in words.
  const std::vector<std::string>& left_out() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Where in the joints' range an arm cannot be: a mass matrix that is not positive definite (or so
/// badly conditioned that it might as well not be), or friction that feeds energy into the motion.
/// Asks the corners, the middle and 2000 evenly spread configurations, and goes downhill from the
/// worst ones.
///
/// @returns one line that names the configuration; empty where all is well.
std::string infeasibility(const Model& arm);

}  // namespace veridyn
