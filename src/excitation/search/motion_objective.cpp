#include "excitation/search/motion_objective.hpp"

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

SmoothValue MotionObjective::at(const VectorXd& x) const {
  const MatrixXd gram = columns_->gram(space_.samples(basis_, x), row_weights_);
  return criterion_(gram / static_cast<double>(basis_.time.size()) + given_);
}

VectorXd MotionObjective::gradient(const VectorXd& x, const SmoothValue& at_x) const {
  const MatrixXd by_gram = at_x.by_gram / static_cast<double>(basis_.time.size());
  return space_.gradient(basis_,
                         columns_->gradient(space_.samples(basis_, x), row_weights_, by_gram));
}

}  // namespace veridyn
