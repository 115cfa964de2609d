#pragma once

#include <array>
#include <vector>

#include "diagnosis/evidence/numerics.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// phi' A phi - 2 b' phi over the ten parameters of a load: change of the sum of squares by the load,
/// with the nuisance parameters fitted.
struct LoadCost {
  MatrixXd A;
  VectorXd b;

  double cost(const VectorXd& phi) const { return phi.dot(A * phi) - 2.0 * b.dot(phi); }
};

/// A point mass and what it costs.
struct PointLoad {
  InertialParameters phi = InertialParameters::Zero();
  double cost = 0.0;
  double mass() const { return phi[0]; }
  Eigen::Vector3d moment() const { return phi.segment<3>(1); }
};

/// Local minima from several first masses and places, one for each start.
/// @param h  the moment from which the places start [kg m].
/// @param reach  [m] that the centre may be away from the frame, along each axis.
std::vector<PointLoad> all_point_loads(const LoadCost& f, const Eigen::Vector3d& h,
                                       double reach = numerics::kAnywhere);

/// The best of all, or the minimum next to `near` where there is one.
PointLoad fit_point_load(const LoadCost& f, const PointLoad* near,
                         double reach = numerics::kAnywhere);

/// Inertia about the centre beyond the point mass; least squares.
Eigen::Matrix<double, 6, 1> load_extent(const LoadCost& f, const PointLoad& s);

/// True for each axis of the frame along which the torques determine the load's position, beyond
/// the regularisation towards zero.
std::array<bool, 3> seen_directions(const LoadCost& f, const PointLoad& at);

}  // namespace veridyn
