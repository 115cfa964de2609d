#pragma once

#include <vector>

#include "diagnosis/unnamed/motion_signals.hpp"
#include "identification/estimation/additive_regression.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// Dependence of one joint's residual on signals, found on training recordings and measured on
/// others.
struct Dependence {
  int joint = 0;
  AdditiveModel model;
  /// Share of the residual's mean square that the first so many terms predict: on held-out folds of
  /// the training recordings, and on the test recordings; one entry for each chosen term.
  std::vector<double> predicted_of_folds, predicted_of_test;
};

/// Smooth terms of one joint: every signal, and products that friction, elasticity and forces make.
std::vector<SmoothTerm> smooth_terms(const std::vector<MotionSignal>& signals, int joint,
                                     const Thresholds& limits);

/// @param terms  as smooth_terms() of the joint.
Dependence find_dependence(int joint, const MotionRows& train, const MotionRows& test,
                           const std::vector<SmoothTerm>& terms, const Thresholds& limits);

/// Points of one chosen term with a 95 % band (jackknife over the folds), its mean over the
/// training rows taken away.
/// @param effort  unit of the joint's torque or force.
UnnamedShape shape_of(const Dependence& found, size_t k, const MotionRows& train,
                      const std::vector<SmoothTerm>& terms, const std::string& effort);

/// Describes the curve: one-sided, periodic, odd or even, saturating, with memory.
std::string shape_words(const UnnamedShape& shape, const std::vector<MotionSignal>& of);

}  // namespace veridyn
