#include "excitation/search/motion_objective.hpp"

#include <utility>

namespace veridyn {
namespace {

// A function of the weighted sum of all joints' Gram matrices.
MotionObjective::JointCriterion of_sum(VectorXd row_weights, MatrixXd given,
                                       MotionObjective::Criterion criterion) {
  return [squares = VectorXd(row_weights.cwiseAbs2()), given = std::move(given),
          criterion = std::move(criterion)](const std::vector<MatrixXd>& grams) {
    MatrixXd sum = given;
    for (size_t i = 0; i < grams.size(); ++i)
      sum += squares[static_cast<Eigen::Index>(i)] * grams[i];
    const SmoothValue at = criterion(sum);
    SmoothJointValue out{at.value, {}};
    for (const double square : squares) out.by_gram.push_back(square * at.by_gram);
    return out;
  };
}

}  // namespace

MotionObjective::MotionObjective(const MotionSpace& space,
                                 std::shared_ptr<const StackedColumns> columns,
                                 VectorXd row_weights, MatrixXd given, Criterion criterion,
                                 int instants)
    : MotionObjective(space, std::move(columns),
                      of_sum(std::move(row_weights), std::move(given), std::move(criterion)),
                      instants) {}

MotionObjective::MotionObjective(const MotionSpace& space,
                                 std::shared_ptr<const StackedColumns> columns,
                                 JointCriterion criterion, int instants)
    : space_(space),
      columns_(std::move(columns)),
      criterion_(std::move(criterion)),
      basis_(space.basis(period_instants(space.frequency(), instants))) {}

std::vector<MatrixXd> MotionObjective::grams(const MotionSamples& motion) const {
  std::vector<MatrixXd> out = columns_->joint_grams(motion);
  for (MatrixXd& one : out) one /= static_cast<double>(motion.rows());
  return out;
}

SmoothJointValue MotionObjective::at(const VectorXd& x) const {
  return criterion_(grams(space_.samples(basis_, x)));
}

VectorXd MotionObjective::gradient(const VectorXd& x, const SmoothJointValue& at_x) const {
  std::vector<MatrixXd> by_gram = at_x.by_gram;
  for (MatrixXd& one : by_gram) one /= static_cast<double>(basis_.time.size());
  return space_.gradient(basis_, columns_->gradient(space_.samples(basis_, x), by_gram));
}

}  // namespace veridyn
