#pragma once

#include <optional>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// A body as people describe it; the inverse of inertial_parameters().
struct PhysicalBody {
  double mass;          ///< [kg]
  Eigen::Vector3d com;  ///< [m]
  Eigen::Matrix<double, 6, 1>
      inertia;  ///< about the centre of mass [kg m^2]: xx, xy, yy, xz, yz, zz
};

/// Nothing if the mass is zero.
std::optional<PhysicalBody> physical_body(const InertialParameters& phi);

/// In numbers of 15 digits, fit for people; nothing if these do not give phi back, or mass or a
/// moment is negative.
std::optional<PhysicalBody> rounded_physical_body(const InertialParameters& phi);

}  // namespace veridyn
