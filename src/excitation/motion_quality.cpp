#include "motion_quality.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {
namespace {

constexpr double kNamedPart = 0.1;  // smallest named entry of a direction of norm one

double range_condition_number(const MatrixXd& W) {
  const VectorXd range = (W.colwise().maxCoeff() - W.colwise().minCoeff()).transpose();
  if (!(range.minCoeff() > 0.0)) return std::numeric_limits<double>::infinity();
  const MatrixXd scaled = W * range.cwiseInverse().asDiagonal();
  return plain_condition_number(scaled.transpose() * scaled);
}

// The eigenvector of the smallest eigenvalue of the Gram matrix, columns of norm one, with the names of its
// largest entries.
std::vector<std::pair<std::string, double>> weakest_direction(
    const MatrixXd& gram, const BaseRegressor& regressor, const std::vector<StandardParameter>& names) {
  const VectorXd d = gram.diagonal().cwiseSqrt().cwiseMax(1e-100).cwiseInverse();
  const MatrixXd scaled = d.asDiagonal() * gram * d.asDiagonal();
  const VectorXd direction = Eigen::SelfAdjointEigenSolver<MatrixXd>(scaled).eigenvectors().col(0);
  std::vector<std::pair<std::string, double>> out;
  for (int b = 0; b < regressor.size(); ++b) {
    const auto column = static_cast<size_t>(regressor.base()[b]);
    if (std::abs(direction[b]) > kNamedPart) out.emplace_back(names[column].name, direction[b]);
  }
  std::sort(out.begin(), out.end(),
            [](const auto& a, const auto& b) { return std::abs(a.second) > std::abs(b.second); });
  return out;
}

}  // namespace

void evaluate_motion(const Model& arm, const BaseRegressor& chosen, const MotionSamples& motion,
                  const MotionSamples& random, const ExcitationOptions& options, Excitation& out) {
  const std::vector<StandardParameter> names = standard_parameters(arm);
  out.base_parameters = chosen.size();
  for (const int c : chosen.base()) out.base.push_back(names[c].name);
  const MatrixXd gram = chosen.gram(motion) / static_cast<double>(motion.rows());
  out.condition_number = scaled_condition_number(gram);
  out.plain_condition_number = plain_condition_number(gram);
  out.range_condition_number = range_condition_number(chosen.stacked(motion));
  MatrixXd with_given = gram;
  const double seconds = motion.time[motion.rows() - 1] - motion.time[0];
  for (const MotionSamples& before : options.given) {
    const double lasts = before.time[before.rows() - 1] - before.time[0];
    with_given += lasts / seconds / static_cast<double>(before.rows()) * chosen.gram(before);
  }
  out.condition_number_with_given = scaled_condition_number(with_given);
  const MatrixXd& basis = chosen.orthogonal_basis();
  out.orthogonal_condition_number = scaled_condition_number(basis.transpose() * gram * basis);
  out.weakest = weakest_direction(gram, chosen, names);
  out.start_condition_number = scaled_condition_number(chosen.gram(random));
}

EssentialParameters evaluate_essential(const Model& arm, const EssentialColumns& columns, double share,
                                    const BaseRegressor& chosen, const MotionSamples& motion) {
  const std::vector<StandardParameter> names = standard_parameters(arm);
  EssentialParameters out;
  out.share = share;
  out.count = chosen.size();
  const MatrixXd gram = chosen.gram(motion) / static_cast<double>(motion.rows());
  out.condition_number = scaled_condition_number(gram);
  out.plain_condition_number = plain_condition_number(gram);
  out.range_condition_number = range_condition_number(chosen.stacked(motion));
  for (const WeakColumn& weak : columns.non_essential)
    out.non_essential.emplace_back(names[weak.column].name, weak.share);
  return out;
}

Discrimination evaluate_discrimination(const Question& question, const MatrixXd& gram) {
  Discrimination out;
  std::tie(out.first, out.second) = question.rival_names;
  const auto [first, second] = rival_remainders(gram, question.scale, question.rivals);
  const auto share = [](const RivalLeft& r) {
    return r.alone > 0.0 ? std::sqrt(r.left / r.alone) : 0.0;
  };
  out.first_left = std::sqrt(first.left);
  out.second_left = std::sqrt(second.left);
  out.first_share = share(first);
  out.second_share = share(second);
  out.bodies_known = question.bodies_known;
  return out;
}

}  // namespace veridyn
