#include "excitation/search/question.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "regressor/random_states.hpp"
#include "kinematics/motion_limits.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// The size of each joint's torque: of the arm's own values at random states, or its largest effort.
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
    const double effort = arm.coordinates()[static_cast<size_t>(i)].limits.effort;
    if (!std::isfinite(effort)) return VectorXd::Ones(arm.joints());
    size[i] = effort;
  }
  return size;
}

// Information of recorded motions per second of them, in units of one instant of the new motion.
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
  if (rounded_deviations) return {space, rounded, *rounded_deviations, instants};
  const auto smoothed = [this, sharpness](const MatrixXd& gram) { return smooth(gram, sharpness); };
  return {space, rounded, row_weights, rounded_given, smoothed, instants};
}

MatrixXd Question::exact_gram(const MotionSamples& motion) const {
  return exact->gram(motion, row_weights) / static_cast<double>(motion.rows()) + exact_given;
}

double Question::cost(const MotionSamples& motion) const {
  if (!exact_deviations) return verdict(exact_gram(motion));
  std::vector<MatrixXd> grams = exact->joint_grams(motion);
  for (MatrixXd& one : grams) one /= static_cast<double>(motion.rows());
  return (*exact_deviations)(grams).value;
}

namespace {

RelativeDeviations relative_deviations(const BaseRegressor& regressor,
                                       const ExcitationOptions& options, const Model& known,
                                       double seconds) {
  const TorqueNoise noise = options.noise.value_or(usual_noise(known));
  require(noise.share.size() == known.joints() && noise.share.minCoeff() > 0.0,
          "excitation: found noise of ", noise.share.size(), " joints, expected ", known.joints(),
          " positive shares.");
  std::vector<MatrixXd> given;
  for (int i = 0; i < known.joints(); ++i) {
    const VectorXd own = VectorXd::Unit(known.joints(), i);
    given.push_back(given_information(*regressor.columns(), own, options.given, seconds));
  }
  return {known, regressor, noise.share, std::move(given)};
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
  // The thesis's condition number is that of rows as they are.
  out.row_weights = options.criterion == ExcitationCriterion::kCondition
                        ? VectorXd::Ones(arm.joints())
                        : VectorXd(torque_sizes(options.powered.value_or(arm)).cwiseInverse());
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
    out.exact_deviations = relative_deviations(exact, options, *known, seconds);
    out.rounded_deviations = relative_deviations(rounded, options, *known, seconds);
  }
  out.exact_given = given_information(*out.exact, out.row_weights, options.given, seconds);
  out.rounded_given = given_information(*out.rounded, out.row_weights, options.given, seconds);
  return out;
}

}  // namespace veridyn
