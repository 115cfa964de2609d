#pragma once

#include <optional>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// Mass, centre and central inertia of a body; the inverse of inertial_parameters().
struct PhysicalBody {
  double mass;          ///< [kg]
  Eigen::Vector3d com;  ///< [m]
  Eigen::Matrix<double, 6, 1>
      inertia;  ///< about the centre of mass [kg m^2]: xx, xy, yy, xz, yz, zz
};

/// The physical parameters of phi; nullopt if the mass is zero.
std::optional<PhysicalBody> physical_body(const InertialParameters& phi);

/// The physical parameters rounded to 15 digits for readable files; nullopt if phi does not follow from the
/// rounded values, or if the mass or a moment is negative.
std::optional<PhysicalBody> rounded_physical_body(const InertialParameters& phi);

}  // namespace veridyn
