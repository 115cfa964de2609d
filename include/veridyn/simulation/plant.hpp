// simulation/: an arm with its effects, sensors and hidden causes as a plant in place of the real one.
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
  /// A substep is accepted if its estimated error of every q and dq h is below tolerance * (|dq| h
  /// + rest), with the estimate of order three for a method of order four.
  double tolerance = 1e-6;
  double rest = 1e-6;        ///< [rad] or [m]; bound of the error at standstill
  int most_substeps = 2000;  ///< largest number of substeps per step
};

/// Forward dynamics of an arm with all its effects:
///
///   M(q) ddq + C(q, dq) dq + g(q) + effects = tau
///
/// Nystroem's method of order four for second-order equations (Hairer, Norsett and Wanner, Solving
/// ODEs I, 1993, ch. II.14; error estimate of order three as in ch. II.4), with as many substeps as
/// the tolerance requires. Its two middle stages have the same position: for arms that are small
/// enough for the processor's vectors the second one costs next to nothing.
///
/// Dry friction (Coulomb, Stribeck, asymmetric, load- and position-dependent, ...) is set-valued:
/// at rest it takes any value up to its level, so that a joint at rest stays at rest, and a sliding
/// joint reverses exactly where its velocity is zero (the substep ends there). The sticking and the
/// sliding axes follow from Gauss' principle of least constraint with bounds on the friction forces, unique in
/// the accelerations for any number of coupled axes. Below kRestSpeed the regularised sign of the effects is
/// *not* used; above it the forces are those of the effects. Friction with memory follows the true path:
/// substeps end where its axis reverses.
///
/// Effects that describe measured motion only (transmission_compliance) are not supported, see
/// left_out().
///
/// Allocates in the constructor alone. One object serves one thread.
class Plant final : public Engine {
 public:
  /// @throws InvalidInput  a body or an effect has no values, or, at some configuration in the
  /// joints' range, the mass matrix is not positive definite or friction drives the motion; the
  /// message gives the configuration.
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
  std::optional<JointIndex> failed_joint() const override;

  /// Torques of all effects at the last evaluated instant, friction at rest included, (n): tau = M
  /// ddq + C dq + g + these.
  const VectorXd& effect_torques() const;

  /// Numbers of substeps accepted and rejected since set_state().
  struct Work {
    long taken = 0;
    long refused = 0;
  };
  Work work() const;

  /// Effects of the model that a forward simulation does not support, in words.
  const std::vector<std::string>& left_out() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Searches the joints' range for configurations without physical meaning: a mass matrix that is
/// not positive definite (or nearly singular), or friction that feeds energy into the motion.
/// Checks the corners, the middle and 2000 evenly spread configurations, and descends from the
/// worst ones.
///
/// @returns one line with the configuration; empty if there is none.
std::string infeasibility(const Model& arm);

}  // namespace veridyn
