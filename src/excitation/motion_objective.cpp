#include "motion_objective.hpp"

#include <utility>

namespace veridyn {

MotionObjective::MotionObjective(const MotionSpace& space,
                                 std::shared_ptr<const StackedColumns> columns,
                                 VectorXd row_weights, MatrixXd given, Criterion criterion,
                                 int instants)
    : space_(space),
      columns_(std::move(columns)),
      row_weights_(std::move(row_weights)),
      given_(std::move(given)),
      criterion_(std::move(criterion)),
      basis_(space.basis(period_instants(space.frequency(), instants))) {}

MatrixXd MotionObjective::gram(const VectorXd& x) const {
  const auto instants = static_cast<double>(basis_.time.size());
  return columns_->gram(space_.samples(basis_, x), row_weights_) / instants + given_;
}

double MotionObjective::value(const VectorXd& x) const {
  return criterion_(gram(x)).value;
}

VectorXd MotionObjective::gradient(const VectorXd& x) const {
  const auto instants = static_cast<double>(basis_.time.size());
  const SmoothValue at = criterion_(gram(x));
  return space_.gradient(
      basis_, columns_->gradient(space_.samples(basis_, x), row_weights_, at.by_gram / instants));
}

}  // namespace veridyn
