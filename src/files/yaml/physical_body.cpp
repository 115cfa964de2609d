#include "files/physical_body.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "files/yaml/yaml_text.hpp"

namespace veridyn {
namespace {

// The inertia about the centre of mass by Steiner's theorem.
Eigen::Matrix<double, 6, 1> central_inertia(const InertialParameters& phi,
                                            const Eigen::Vector3d& com) {
  return phi.tail<6>() -
         inertial_parameters(phi[0], com, Eigen::Matrix<double, 6, 1>::Zero()).tail<6>();
}

double rounded(double value) {
  if (std::abs(value) < kYamlRounding) return 0.0;
  const std::string digits = fmt::format("{:.15g}", value);
  std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return value;
}

}  // namespace

std::optional<PhysicalBody> physical_body(const InertialParameters& phi) {
  if (phi[0] == 0.0) return std::nullopt;
  const Eigen::Vector3d com = phi.segment<3>(1) / phi[0];
  return PhysicalBody{phi[0], com, central_inertia(phi, com)};
}

std::optional<PhysicalBody> rounded_physical_body(const InertialParameters& phi) {
  std::optional<PhysicalBody> body = physical_body(phi);
  if (!body || phi[0] < 0.0) return std::nullopt;
  body->com = body->com.unaryExpr(&rounded);
  body->inertia = central_inertia(phi, body->com).unaryExpr(&rounded);
  if (body->inertia[0] < 0.0 || body->inertia[2] < 0.0 || body->inertia[5] < 0.0)
    return std::nullopt;
  const InertialParameters back = inertial_parameters(body->mass, body->com, body->inertia);
  for (int i = 0; i < kBodyParameters; ++i) {
    if (!same_in_yaml(back[i], phi[i])) return std::nullopt;
  }
  return body;
}

}  // namespace veridyn
