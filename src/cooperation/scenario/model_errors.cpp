#include "cooperation/scenario/model_errors.hpp"

#include <limits>

#include "math/random_numbers.hpp"
#include "veridyn/regressor/base_parameters.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {

Model with_parameter_errors(const Model& arm, double share, unsigned seed) {
  if (!(share > 0.0)) return arm;
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  VectorXd phi(parameters.size());
  for (size_t k = 0; k < parameters.size(); ++k)
    phi[static_cast<Eigen::Index>(k)] = parameters[k].value;
  const BaseParameters base = base_parameters(arm);
  const VectorXd beta = base.K * phi;
  RandomNumbers random(seed, 77);
  for (int j = 0; j < base.size(); ++j) {
    const double sign = random.uniform() < 0.5 ? -1.0 : 1.0;
    phi[base.independent[j]] += sign * share * beta[j];
  }
  const VectorXd none = VectorXd::Constant(phi.size(), std::numeric_limits<double>::quiet_NaN());
  return with_values(arm, phi, none);
}

}  // namespace veridyn
