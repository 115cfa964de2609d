#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "excitation/search/base_regressor.hpp"
#include "excitation/search/criterion.hpp"
#include "excitation/search/criterion.hpp"
#include "excitation/search/motion_objective.hpp"
#include "regressor/stacked_columns.hpp"
#include "excitation/search/base_regressor.hpp"
#include "veridyn/excitation/excitation.hpp"

namespace veridyn {

/// Share of the largest speed within which the sign of a velocity is smoothed in a search.
constexpr double kRounding = 0.01;

/// Columns, weights and criterion of a search: smooth columns for the descent, exact ones for the final
/// value.
struct Question {
  std::shared_ptr<const StackedColumns> rounded;
  std::shared_ptr<const StackedColumns> exact;
  VectorXd row_weights;  ///< (n)
  VectorXd scale;        ///< scale of the columns
  MatrixXd basis;        ///< basis for ColumnScaling::kOrthogonal
  RivalColumns rivals;   ///< columns of the causes, for kDiscriminate
  bool bodies_known = false;
  std::vector<int> rival_joints;  ///< joints of the two causes, from 0
  std::pair<std::string, std::string> rival_names;
  MatrixXd rounded_given;  ///< information of earlier recordings, per instant of the new motion
  MatrixXd exact_given;

  VectorXd sizes{};  ///< parameter_sizes(), for kAOptimal

  /// Objective of a descent, whose Gram matrix is summed over `instants` of a period.
  MotionObjective objective(const MotionSpace& space, double sharpness, int instants) const;

  /// Weighted Gram matrix per row, earlier recordings included.
  MatrixXd exact_gram(const MotionSamples& motion) const;

  /// The exact criterion for the samples of a motion; smaller is better.
  double cost(const MotionSamples& motion) const;

  /// The smooth approximation of the criterion; only kCondition has a sharpness.
  SmoothValue smooth(const MatrixXd& gram, double sharpness) const;

  /// The exact criterion from the exact columns' Gram matrix per row.
  double exact_criterion(const MatrixXd& gram) const;

  ExcitationCriterion criterion = ExcitationCriterion::kCondition;
  ColumnScaling scaling = ColumnScaling::kNorm;
};

/// The arm with the values for a prediction, if there is one.
std::optional<Model> values_of(const Model& arm, const ExcitationOptions& options);

/// The question of an excitation whose motion lasts `seconds`.
Question make_question(const Model& arm, const BaseRegressor& exact, const BaseRegressor& rounded,
                       const ExcitationOptions& options, double seconds);

/// Adds the columns of the two causes. @throws InvalidInput  no motion separates them, or there are no values.
void add_rivals(const Model& arm, const ExcitationOptions& options, double rounding,
                Question& question);

}  // namespace veridyn
