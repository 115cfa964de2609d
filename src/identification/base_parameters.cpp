#include "veridyn/identification/base_parameters.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "identification/base_expression.hpp"
#include "math/singular_values.hpp"
#include "regressor/arm_columns.hpp"
#include "regressor/random_states.hpp"
#include "regressor/stacked_columns.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kNegligible =
    1e-7;  // smaller coefficients, relative to the largest of the row, are rounding

// Scales columns to norm one; zero columns are kept.
MatrixXd scaled(const MatrixXd& R, VectorXd& norms) {
  norms = R.colwise().norm().transpose();
  const double largest = norms.size() > 0 ? norms.maxCoeff() : 0.0;
  MatrixXd out = R;
  for (Eigen::Index j = 0; j < R.cols(); ++j) {
    if (norms[j] <= 1e-14 * largest) norms[j] = 0.0;
    out.col(j) = norms[j] > 0.0 ? VectorXd(R.col(j) / norms[j]) : VectorXd::Zero(R.rows());
  }
  return out;
}

// @param gap  output: last kept over first dropped singular value.
int rank_of(const VectorXd& singular_values, double tolerance, double& gap) {
  int rank = 0;
  while (rank < singular_values.size() && singular_values[rank] > tolerance * singular_values[0])
    ++rank;
  const bool full = rank == singular_values.size() || singular_values[rank] == 0.0;
  gap = rank == 0 ? 0.0
        : full    ? std::numeric_limits<double>::infinity()
                  : singular_values[rank - 1] / singular_values[rank];
  return rank;
}

// Gram-Schmidt in the preferred order, twice for accuracy: a column is independent if its remainder exceeds a
// threshold. The threshold lies between the smallest remainder that is kept and the largest that is dropped,
// so that exactly `rank` columns are kept.
std::vector<int> leading_columns(const MatrixXd& A, const std::vector<int>& order, int rank) {
  for (double threshold = 1e-2; threshold > 1e-13; threshold *= 0.1) {
    MatrixXd Q(A.rows(), rank);
    std::vector<int> chosen;
    bool too_many = false;
    for (const int j : order) {
      VectorXd v = A.col(j);
      if (v.squaredNorm() == 0.0) continue;
      const auto basis = Q.leftCols(chosen.size());
      v -= basis * (basis.transpose() * v);
      v -= basis * (basis.transpose() * v);
      if (v.norm() < threshold) continue;
      if (static_cast<int>(chosen.size()) == rank) {
        too_many = true;
        break;
      }
      Q.col(chosen.size()) = v / v.norm();
      chosen.push_back(j);
    }
    if (!too_many && static_cast<int>(chosen.size()) == rank) return chosen;
  }
  // If no threshold separates them, the best-conditioned set is used.
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(A);
  std::vector<int> chosen;
  for (int i = 0; i < rank; ++i) chosen.push_back(qr.colsPermutation().indices()[i]);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

void describe(BaseParameters& base, const VectorXd& norms, const std::vector<std::string>& names) {
  const auto standard = static_cast<Eigen::Index>(names.size());
  base.classes.assign(names.size(), Identifiability::kInCombination);
  for (Eigen::Index j = 0; j < standard; ++j) {
    if (norms[j] == 0.0) base.classes[j] = Identifiability::kNot;
  }
  for (int i = 0; i < base.size(); ++i) {
    const int own = base.independent[i];
    const bool alone = (base.K.row(i).array() != 0.0).count() == 1;
    if (alone) base.classes[own] = Identifiability::kAlone;
    base.names.push_back(names[own]);
    base.expressions.push_back(expression_of(base.K.row(i).transpose(), own, names));
  }
}

}  // namespace

std::vector<int> preferred_columns(const std::vector<StandardParameter>& parameters) {
  std::vector<int> order;
  const int count = static_cast<int>(parameters.size());
  for (int j = 0; j < count; ++j) {
    if (parameters[j].effect) order.push_back(j);
  }
  for (int j = 0; j < count; ++j) {
    if (!parameters[j].effect && parameters[j].component > 0) order.push_back(j);
  }
  for (int j = 0; j < count; ++j) {
    if (!parameters[j].effect && parameters[j].component == 0) order.push_back(j);
  }
  return order;
}

BaseParameters base_parameters(const SquareRootInformation& factor,
                               const std::vector<int>& preference, double tolerance) {
  BaseParameters base;
  VectorXd norms;
  const MatrixXd A = scaled(factor.R(), norms);
  if (A.cols() == 0) return base;  // an arm without bodies and effects has no parameters
  base.singular_values = singular_values(A);
  const int rank = rank_of(base.singular_values, tolerance, base.rank_gap);
  base.independent = leading_columns(A, preference, rank);
  base.K = MatrixXd::Zero(rank, A.cols());
  MatrixXd independent(A.rows(), rank);
  for (int i = 0; i < rank; ++i)
    independent.col(i) = A.col(base.independent[i]);
  const MatrixXd K = Eigen::HouseholderQR<MatrixXd>(independent).solve(A);
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    for (int i = 0; i < rank; ++i) {
      if (std::abs(K(i, j)) < kNegligible) continue;
      base.K(i, j) = K(i, j) * norms[j] / norms[base.independent[i]];
    }
  }
  for (int i = 0; i < rank; ++i) {
    base.K.col(base.independent[i]).setZero();
    base.K(i, base.independent[i]) = 1.0;
  }
  describe(base, norms, factor.columns());
  return base;
}

SquareRootInformation random_state_factor(const Model& arm, int states, unsigned seed,
                                          const std::vector<std::string>& still) {
  SquareRootInformation factor(parameter_names(standard_parameters(arm)));
  const StackedColumns all(arm.joints(), arm_columns(arm, 0.0));
  const MatrixXd rows = all.stacked(random_states(arm, states, seed, still));
  factor.absorb(rows, VectorXd::Zero(rows.rows()));
  return factor;
}

SquareRootInformation identifiable_factor(const Model& arm, unsigned seed,
                                          const std::vector<std::string>& still) {
  constexpr int kStates = 200;
  const SquareRootInformation all = random_state_factor(arm, kStates, seed, still);
  std::vector<std::string> free;
  for (const StandardParameter& p : standard_parameters(arm)) {
    if (!p.fixed) free.push_back(p.name);
  }
  return static_cast<int>(free.size()) == all.size()
             ? all
             : all.restricted(free).restricted(all.columns());
}

BaseParameters base_parameters(const Model& arm) {
  const int states =
      20 + 4 * static_cast<int>(arm.bodies().size()) * kBodyParameters / arm.joints();
  return base_parameters(random_state_factor(arm, states, 1),
                         preferred_columns(standard_parameters(arm)));
}

BaseParameters identifiable_base_parameters(const Model& arm) {
  return base_parameters(identifiable_factor(arm, 1),
                         preferred_columns(standard_parameters(arm)));
}

}  // namespace veridyn
