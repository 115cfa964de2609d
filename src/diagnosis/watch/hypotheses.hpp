#pragma once

#include <string>
#include <vector>

#include "diagnosis/candidates.hpp"
#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "regressor/effect_along.hpp"
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
};

/// Motion of a step: (rows x n).
struct StepMotion {
  VectorXd time;
  MatrixXd q, dq, ddq;
  double spacing = 0.0;  ///< [s] between new values of the slowest signal
};

/// Torques of an identified model along a continuing motion, and the contribution of every hypothesis. Effects
/// with memory keep it from step to step.
class Hypotheses {
 public:
  /// @throws InvalidInput  the model lacks values; a link is no frame.
  Hypotheses(const Model& arm, const std::vector<std::string>& links, const WatchNumbers& numbers);

  const std::vector<Hypothesis>& all() const { return all_; }
  int size() const { return static_cast<int>(all_.size()); }

  struct Answer {
    MatrixXd torque;                ///< (rows x n) of the model
    std::vector<MatrixXd> parts;    ///< (rows x n): gravity, motion of the bodies, effects; absolute
    std::vector<MatrixXd> columns;  ///< (rows x n), one for each hypothesis
    /// (rows x n) dry friction of axes at rest, or whose velocity may have changed its sign between two values:
    /// it is undetermined within this bound.
    MatrixXd rest_friction;
  };
  void evaluate(const StepMotion& motion, Answer& out);

  /// Restarts the memories after a pause.
  void reset();

 private:
  struct Dry {
    size_t effect;
    double level = 0.0, fastest = 0.0;
  };
  void add_effects(const StepMotion& motion, const MatrixXd& rigid, Answer& out);
  MatrixXd load_column(int body, int parameter, Eigen::Index rows) const;
  void channel_columns(const StepMotion& motion, Answer& out) const;

  const WatchNumbers& numbers_;
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
};

}  // namespace veridyn::watching
