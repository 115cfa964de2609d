#pragma once

#include <functional>
#include <vector>

#include "diagnosis/watch/hypotheses.hpp"
#include "diagnosis/watch/smoothed_rows.hpp"
#include "diagnosis/watch/step.hpp"

namespace veridyn::watching {

/// Combines smoothed rows into steps.
class StepBuilder {
 public:
  /// @param seconds  length of a step.
  StepBuilder(Hypotheses& hypotheses, double seconds) : hypotheses_(hypotheses), seconds_(seconds) {}

  std::function<void(const Step&)> on_step;

  /// @param spacing  [s] between new values of the slowest signal.
  void add(const SmoothedRow& row, double dt, double spacing);
  void restart();

 private:
  void finish(double spacing);

  Hypotheses& hypotheses_;
  double seconds_;
  std::vector<SmoothedRow> rows_;
  bool follows_ = false;
  Hypotheses::Answer answer_;
};

}  // namespace veridyn::watching
