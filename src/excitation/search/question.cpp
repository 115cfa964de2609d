#include "excitation/search/question.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "regressor/random_states.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// Reference torque of each joint: that of the arm's own values at random states, or its largest
// effort.
VectorXd torque_sizes(const Model& arm) {
  const auto phi = arm.inertial_values();
  VectorXd size = VectorXd::Ones(arm.joints());
  if (phi) {
    const MotionSamples states = random_states(arm, 200);
    MatrixXd tau;
    RegressorBatch(arm).torques(states.q, states.dq, states.ddq, *phi, tau);
    for (int i = 0; i < arm.joints(); ++i) {
      const double rms = std::sqrt(tau.col(i).squaredNorm() / static_cast<double>(tau.rows()));
      if (rms > 0.0) size[i] = rms;
    }
    return size;
  }
  for (int i = 0; i < arm.joints(); ++i) {
    const double effort = arm.coordinates()[i].limits.effort;
    if (!std::isfinite(effort)) return VectorXd::Ones(arm.joints());
    size[i] = effort;
  }
  return size;
}

// Information of recorded motions per second, in units of one instant of the new motion.
MatrixXd given_information(const StackedColumns& columns, const VectorXd& row_weights,
                           const std::vector<MotionSamples>& given, double seconds) {
  MatrixXd sum = MatrixXd::Zero(columns.chosen(), columns.chosen());
  for (const MotionSamples& motion : given) {
    require(motion.rows() >= 2, "excitation: a given recording has ", motion.rows(),
            " rows, expected at least two.");
    const double lasts = motion.time[motion.rows() - 1] - motion.time[0];
    sum += lasts / seconds / static_cast<double>(motion.rows()) * columns.gram(motion, row_weights);
  }
  return sum;
}

}  // namespace

std::optional<Model> values_of(const Model& arm, const ExcitationOptions& options) {
  if (options.valued) return options.valued;
  if (options.powered) return options.powered;
  if (arm.inertial_values()) return arm;
  return std::nullopt;
}

SmoothValue Question::smooth(const MatrixXd& gram, double sharpness) const {
  if (criterion == ExcitationCriterion::kAOptimal) return smooth_a_optimality(gram, sizes);
  if (criterion == ExcitationCriterion::kDOptimal) return smooth_d_optimality(gram, scale);
  if (criterion == ExcitationCriterion::kDiscriminate)
    return smooth_discrimination(gram, scale, rivals);
  if (scaling == ColumnScaling::kOrthogonal) {
    SmoothValue out =
        smooth_condition(basis.transpose() * gram * basis, ColumnNorm::kOne, sharpness);
    out.by_gram = basis * out.by_gram * basis.transpose();
    return out;
  }
  const bool norm = scaling == ColumnScaling::kNorm;
  return smooth_condition(gram, norm ? ColumnNorm::kOne : ColumnNorm::kAsTheyAre, sharpness);
}

double Question::verdict(const MatrixXd& gram) const {
  if (criterion == ExcitationCriterion::kAOptimal) return smooth_a_optimality(gram, sizes).value;
  if (criterion == ExcitationCriterion::kDOptimal) return -log_determinant(gram, scale);
  if (criterion == ExcitationCriterion::kDiscriminate)
    return smooth_discrimination(gram, scale, rivals).value;
  if (scaling == ColumnScaling::kOrthogonal)
    return std::log(scaled_condition_number(basis.transpose() * gram * basis));
  return std::log(scaling == ColumnScaling::kNorm ? scaled_condition_number(gram)
                                                  : plain_condition_number(gram));
}

MotionObjective Question::objective(const MotionSpace& space, double sharpness,
                                    int instants) const {
  const auto smoothed = [this, sharpness](const MatrixXd& gram) { return smooth(gram, sharpness); };
  return {space, rounded, row_weights, rounded_given, smoothed, instants};
}

MatrixXd Question::exact_gram(const MotionSamples& motion) const {
  return exact->gram(motion, row_weights) / static_cast<double>(motion.rows()) + exact_given;
}

double Question::cost(const MotionSamples& motion) const { return verdict(exact_gram(motion)); }

namespace {

// The thesis' condition number uses unweighted rows; a confidence ellipsoid needs rows divided by
// their noise.
VectorXd weights_of_rows(const Model& arm, const ExcitationOptions& options) {
  if (options.criterion == ExcitationCriterion::kCondition) return VectorXd::Ones(arm.joints());
  if (options.criterion == ExcitationCriterion::kDiscriminate)
    return torque_sizes(options.powered.value_or(arm)).cwiseInverse();
  const TorqueNoise noise =
      options.noise.value_or(usual_noise(values_of(arm, options).value_or(arm)));
  require(noise.deviation.size() == arm.joints() && noise.deviation.minCoeff() > 0.0,
          "excitation: found noise of ", noise.deviation.size(), " joints, expected ", arm.joints(),
          " positive deviations.");
  return noise.deviation.cwiseInverse();
}

}  // namespace

Question make_question(const Model& arm, const BaseRegressor& exact, const BaseRegressor& rounded,
                       const ExcitationOptions& options, double seconds) {
  Question out;
  out.criterion = options.criterion;
  out.scaling = options.scaling;
  out.exact = exact.columns();
  out.rounded = rounded.columns();
  out.scale = exact.scale();
  out.basis = exact.orthogonal_basis();
  out.row_weights = weights_of_rows(arm, options);
  if (options.criterion == ExcitationCriterion::kDiscriminate) {
    require(options.between.has_value(),
            "excitation: found the criterion discriminate without two rivals.");
    add_rivals(arm, options, kRounding, out);
  }
  if (options.criterion == ExcitationCriterion::kAOptimal) {
    const std::optional<Model> known = values_of(arm, options);
    require(known.has_value(),
            "excitation: the criterion a-optimal is about deviations relative to "
            "the arm's values, but '",
            arm.name(), "' has none and no other model is given.");
    out.sizes = parameter_sizes(*known, exact);
  }
  out.exact_given = given_information(*out.exact, out.row_weights, options.given, seconds);
  out.rounded_given = given_information(*out.rounded, out.row_weights, options.given, seconds);
  return out;
}

}  // namespace veridyn
