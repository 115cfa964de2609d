#include "excitation/search/question.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "regressor/random_states.hpp"
#include "regressor/stacked_columns.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {
namespace {

constexpr double kFloorOfTorque = 1e-3;
constexpr int kStates = 400;
constexpr double kNoTorque2 = 1e-12;  // share of the largest joint's mean square below which a joint has no torque
constexpr double kRidge = 1e-14;

// The inverse of a positive matrix, scaled to a diagonal of ones first; a ridge keeps it finite.
MatrixXd inverse_of(const MatrixXd& M) {
  const VectorXd d = M.diagonal().cwiseSqrt().cwiseMax(1e-150).cwiseInverse();
  const MatrixXd one = MatrixXd::Identity(M.rows(), M.cols());
  const MatrixXd scaled = d.asDiagonal() * M * d.asDiagonal();
  const Eigen::LLT<MatrixXd> llt(scaled + kRidge * one);
  if (llt.info() == Eigen::Success) return d.asDiagonal() * llt.solve(one) * d.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scaled);
  const VectorXd values = eigen.eigenvalues().cwiseMax(kRidge).cwiseInverse();
  const MatrixXd V = d.asDiagonal() * eigen.eigenvectors();
  return V * values.asDiagonal() * V.transpose();
}

// Reference sizes for relative deviations of the base parameters: |beta_b|, but at least the value that
// causes kFloorOfTorque of all torques at random states, because a deviation relative to zero is meaningless.
// @param arm  with values.
VectorXd parameter_sizes(const Model& arm, const BaseRegressor& regressor) {
  const VectorXd beta = regressor.combination() * standard_values(arm);
  const std::vector<MatrixXd> grams = regressor.columns()->joint_grams(random_states(arm, kStates));
  VectorXd square(arm.joints());
  for (Eigen::Index i = 0; i < square.size(); ++i)
    square[i] = beta.dot(grams[i] * beta) / kStates;
  const double none = std::max(1e-300, kNoTorque2 * square.maxCoeff());
  VectorXd by_one = VectorXd::Zero(beta.size());  // squared torque of one unit, relative to all torques
  for (Eigen::Index i = 0; i < square.size(); ++i)
    by_one += grams[i].diagonal() / kStates / std::max(square[i], none);
  return beta.cwiseAbs().cwiseMax(kFloorOfTorque *
                                  by_one.cwiseMax(1e-300).cwiseSqrt().cwiseInverse());
}

// A-optimality with relative deviations: the accuracy of the base parameters in least squares, with the Gram
// matrix G of rows divided by their noise:
//
//   ln( 1/p sum_b sqrt(inv(G)_bb) / size_b )
//
// It equals the logarithm of mean_relative in predict_identification(), up to a constant that does not depend
// on the motion.
SmoothValue smooth_a_optimality(const MatrixXd& gram, const VectorXd& size) {
  const MatrixXd P = inverse_of(gram);
  const VectorXd deviation = P.diagonal().cwiseMax(1e-300).cwiseSqrt();
  const double mean = deviation.cwiseQuotient(size).mean();
  const VectorXd by_variance =
      (0.5 / (mean * static_cast<double>(size.size())) / (deviation.array() * size.array())).matrix();
  return {std::log(mean), -P * by_variance.asDiagonal() * P};
}

// Reference torque of each joint: rms torque of the arm's own values at random states, or its largest effort.
VectorXd torque_sizes(const Model& arm) {
  const auto phi = arm.inertial_values();
  VectorXd size = VectorXd::Ones(arm.joints());
  if (phi) {
    const MotionSamples states = random_states(arm, 200);
    MatrixXd tau;
    TorqueRegressor(arm).torques(states.q, states.dq, states.ddq, *phi, tau);
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

// Information of recorded motions, scaled to one instant of the new motion.
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

double Question::exact_criterion(const MatrixXd& gram) const {
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

double Question::cost(const MotionSamples& motion) const { return exact_criterion(exact_gram(motion)); }

namespace {

// The condition number of the thesis is for unweighted rows; a confidence ellipsoid needs rows divided by their
// noise.
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
