#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/candidates.hpp"
#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect.hpp"
#include "regressor/effect_along.hpp"
#include "diagnosis/watch/smoothed_rows.hpp"
#include "diagnosis/watch/step.hpp"
#include "diagnosis/watch/watch_numbers.hpp"

namespace veridyn::watching {

/// One possible change, of one unknown size.
struct Hypothesis {
  Candidate of;
  std::string unit = {};
  /// Columns fitted together with it during isolation: the first moments of a load.
  std::vector<int> companions = {};
  bool companion = false;  ///< a column that only accompanies other hypotheses

  bool along_axis() const { return std::holds_alternative<NewEffect>(of.cause); }
  EffectTraits traits() const { return find_effect(effect_of(of.cause)).traits(); }
  /// [rad/s], [m/s] at which one unit is a torque of one: `slow` for viscous friction, else 1.
  double speed(double slow) const {
    const EffectTraits t = traits();
    return t.uses_velocity && t.dry == DryFriction::kNone ? slow : 1.0;
  }
};

/// From rows to steps: what an identified model leaves of the torques, and the contribution of every hypothesis to
/// them. Effects with memory keep it from step to step.
class Hypotheses {
 public:
  /// @param links    frames that a load may be added to; empty: of those that move, bodies and last frames.
  /// @param seconds  length of a step.
  /// @throws InvalidInput  the model lacks values; a link is no frame.
  Hypotheses(const Model& arm, const std::vector<std::string>& links, double seconds, const WatchNumbers& numbers);

  const std::vector<Hypothesis>& all() const { return all_; }

  /// @param dt       [s] from row to row.
  /// @param spacing  [s] between new values of the slowest signal.
  /// @returns the step that the row completes.
  std::optional<Step> add(const SmoothedRow& row, double dt, double spacing);

  /// After a pause: memories are empty, and the next step does not follow.
  void restart();

 private:
  struct Dry {
    size_t effect;
    double level = 0.0, fastest = 0.0;
  };
  MotionView motion() const { return {time_, q_, dq_, ddq_}; }
  Step make_step(double dt, double spacing);  ///< the means of the rows since the last step
  void add_effects(const MatrixXd& rigid, double spacing, MatrixXd& torque, Step& out);  ///< adds torques of the model's effects
  void add_columns(const MatrixXd& torque, double dt, Step& out);

  const WatchNumbers& numbers_;
  double seconds_;
  Model arm_, loaded_;
  TorqueRegressor bodies_, loads_;
  VectorXd phi_;
  std::vector<ColumnsInPieces> effects_;
  std::vector<Dry> dry_;
  std::vector<Hypothesis> all_;
  std::vector<ColumnsInPieces> axis_;         // of the hypotheses along axes, in their order
  std::vector<const ChannelEffect*> channel_; // of those of channels, in their order
  std::vector<int> body_of_load_;             // among the bodies of loaded_
  std::vector<MatrixXd> Y_;
  // Rows of the present step.
  Eigen::Index rows_ = 0;
  bool follows_ = false;
  VectorXd time_;
  MatrixXd q_, dq_, ddq_, tau_;
};

}  // namespace veridyn::watching
