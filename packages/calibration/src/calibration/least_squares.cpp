#include "least_squares.hpp"

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <memory>
#include <thread>

namespace veridyn::internal {
namespace {

constexpr double kCostTolerance = 1e-12;  // relative decrease of the cost at which it stops
constexpr double kStepTolerance = 1e-12;  // relative step at which it stops

class ObservationCost : public ceres::CostFunction {
 public:
  ObservationCost(const Observation& observation, const std::vector<int>& sizes)
      : observation_(observation) {
    set_num_residuals(observation.size);
    for (const int size : sizes) mutable_parameter_block_sizes()->push_back(size);
  }

  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override {
    observation_.residual(x, residuals, jacobians);
    return true;
  }

 private:
  const Observation& observation_;
};

}  // namespace

int LeastSquares::add_unknown(const VectorXd& start, Scope scope) {
  unknowns_.push_back({start, scope});
  return static_cast<int>(unknowns_.size()) - 1;
}

int LeastSquares::add(Observation observation) {
  observations_.push_back(std::move(observation));
  return static_cast<int>(observations_.size()) - 1;
}

int LeastSquares::shared_size() const {
  int size = 0;
  for (const Unknown& u : unknowns_) {
    if (u.scope == Scope::kShared) size += static_cast<int>(u.x.size());
  }
  return size;
}

int LeastSquares::shared_offset(int unknown) const {
  int offset = 0;
  for (int k = 0; k < unknown; ++k) {
    if (unknowns_[at(k)].scope == Scope::kShared)
      offset += static_cast<int>(unknowns_[at(k)].x.size());
  }
  return offset;
}

VectorXd LeastSquares::residual(const Observation& observation) const {
  std::vector<const double*> x;
  for (const int u : observation.unknowns) x.push_back(unknowns_[at(u)].x.data());
  VectorXd r(observation.size);
  observation.residual(x.data(), r.data(), nullptr);
  return r;
}

Minimum LeastSquares::minimise(int threads, int iterations) {
  ceres::Problem::Options owned_here;
  owned_here.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(owned_here);
  std::map<double, std::unique_ptr<ceres::LossFunction>> losses;
  std::vector<char> used(unknowns_.size(), 0);
  for (const Observation& o : observations_) {
    if (!o.active) continue;
    std::vector<int> sizes;
    std::vector<double*> blocks;
    for (const int u : o.unknowns) {
      used[at(u)] = 1;
      sizes.push_back(static_cast<int>(unknowns_[at(u)].x.size()));
      blocks.push_back(unknowns_[at(u)].x.data());
    }
    std::unique_ptr<ceres::LossFunction>& loss = losses[o.loss];
    if (o.loss > 0.0 && !loss) loss = std::make_unique<ceres::HuberLoss>(o.loss);
    problem.AddResidualBlock(new ObservationCost(o, sizes), loss.get(), blocks);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  const auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (std::size_t k = 0; k < unknowns_.size(); ++k) {
    if (used[k] == 0) continue;
    const bool local = unknowns_[k].scope == Scope::kLocal;
    if (local) options.linear_solver_type = ceres::SPARSE_SCHUR;
    ordering->AddElementToGroup(unknowns_[k].x.data(), local ? 0 : 1);
  }
  if (options.linear_solver_type == ceres::SPARSE_SCHUR) options.linear_solver_ordering = ordering;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.num_threads =
      threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  options.max_num_iterations = iterations;
  options.function_tolerance = kCostTolerance;
  options.parameter_tolerance = kStepTolerance;
  options.gradient_tolerance = 0.0;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return {summary.termination_type == ceres::CONVERGENCE, summary.final_cost,
          static_cast<int>(summary.iterations.size()), summary.message};
}

}  // namespace veridyn::internal
