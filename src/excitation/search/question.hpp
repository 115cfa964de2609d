#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "excitation/search/a_optimality.hpp"
#include "excitation/search/criterion.hpp"
#include "excitation/search/motion_objective.hpp"
#include "regressor/stacked_columns.hpp"
#include "excitation/search/base_regressor.hpp"
#include "veridyn/excitation/excitation.hpp"

namespace veridyn {

/// Share of the largest speed within which a search rounds signs off.
constexpr double kRounding = 0.01;

/// What a search is about: columns, weights and criterion, once rounded off for the search and once
/// as they are for the verdict.
struct Question {
  std::shared_ptr<const StackedColumns> rounded;
  std::shared_ptr<const StackedColumns> exact;
  VectorXd row_weights;  ///< (n)
  VectorXd scale;        ///< Scale of the columns
  MatrixXd basis;        ///< Basis of ColumnScaling::kOrthogonal
  RivalColumns rivals;   ///< for kDiscriminate
  bool bodies_known = false;
  std::vector<int> rival_joints;  ///< from 0, of the rivals that stand on one
  MatrixXd rounded_given;  ///< information that is there already, per instant of the new motion
  MatrixXd exact_given;

  VectorXd sizes{};  ///< parameter_sizes(), for kAOptimal

  /// What a search goes down, at some instants of a period.
  MotionObjective objective(const MotionSpace& space, double sharpness, int instants) const;

  /// Weighted, per row, with what is given.
  MatrixXd exact_gram(const MotionSamples& motion) const;

  /// The criterion itself, of the samples of a motion; smaller is better.
  double cost(const MotionSamples& motion) const;

  /// The smooth stand-in of the criterion; only kCondition has a sharpness.
  SmoothValue smooth(const MatrixXd& gram, double sharpness) const;

  /// The criterion itself, of the exact columns' Gram matrix per row.
  double verdict(const MatrixXd& gram) const;

  ExcitationCriterion criterion = ExcitationCriterion::kCondition;
  ColumnScaling scaling = ColumnScaling::kNorm;
};

/// The arm whose values a prediction takes, if there is one.
std::optional<Model> values_of(const Model& arm, const ExcitationOptions& options);

Question make_question(const Model& arm, const BaseRegressor& exact, const BaseRegressor& rounded,
                       const ExcitationOptions& options, double seconds);

/// The two rivals' part of the question. @throws InvalidInput  unknown effect, place, or no values.
void add_rivals(const Model& arm, const ExcitationOptions& options, double rounding,
                Question& question);

}  // namespace veridyn
