#pragma once

#include "veridyn/math/types.hpp"

namespace veridyn {

/// The ten inertial parameters of one body, in this order:
///
///   phi = [m, hx, hy, hz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz]     h = m*c
///
/// m [kg], h [kg*m], I [kg*m^2]; I is the inertia about the origin of the frame (not about the
/// centre of mass) and Ixy, Ixz, Iyz are the entries of the matrix I themselves (Ixy = -integral of
/// x*y dm).
using InertialVector = Eigen::Matrix<double, 10, 1>;

/// Pseudo-inertia of a body: the second moments of its mass distribution,
///
///   J(phi) = [ Sigma  h ]      Sigma = tr(I)/2 * 1 - I = integral of r r' dm
///            [ h'     m ]
///
/// A distribution of positive mass with these ten parameters exists if and only if J is positive
/// definite (semidefinite in the limit: all mass in a plane, on a line or in a point).
/// Source: Wensing, Kim and Slotine, IEEE RA-L 3(1), 2018.
///
/// @returns J (4x4, symmetric): Sigma [kg*m^2], h [kg*m], m [kg].
Eigen::Matrix4d pseudo_inertia(const Eigen::Ref<const InertialVector>& phi);

/// The adjoint of pseudo_inertia: the phi-vector with <J(phi), Z> = phi' * adjoint(Z) for all phi.
///
/// @param Z  (4x4), symmetric; only the symmetric part of another matrix counts.
InertialVector pseudo_inertia_adjoint(const Eigen::Matrix4d& Z);

/// The nearest body of the same mass and centre whose mass has an rms distance of at least `radius`
/// [m] from its centre along all three axes; zero for zero mass.
InertialVector with_minimum_radius(const InertialVector& phi, double radius);

/// The inverse of pseudo_inertia: the ten parameters of a given J (4x4, symmetric).
InertialVector inertial_parameters(const Eigen::Matrix4d& J);

/// The matrix of the weaker condition "I and m are positive":
///
///   D(phi) = [ I  0 ]
///            [ 0  m ]
///
/// D > 0 is necessary and not sufficient for a real body: it ignores h and admits principal moments
/// that violate the triangle inequality. Kept to compare with results of older literature.
Eigen::Matrix4d principal_moment_matrix(const Eigen::Ref<const InertialVector>& phi);

/// Smallest eigenvalue of a symmetric 4x4 matrix.
double smallest_eigenvalue(const Eigen::Matrix4d& J);

/// Distance from singularity, independent of units: the smallest eigenvalue of J after scaling to
/// unit diagonal, J_ij / sqrt(J_ii*J_jj). 1: principal axes about the centre of mass; 0: singular.
///
/// @returns -infinity where a diagonal entry is not positive.
double smallest_scaled_eigenvalue(const Eigen::Matrix4d& J);

/// Log-det Bregman divergence ("entropic" distance) between two pseudo-inertias,
///
///   d(J, J0) = -log det J + log det J0 + tr(inv(J0) * J) - 4  >= 0,
///
/// zero only where J = J0, and the same in every frame and every system of units.
/// Source: Lee, Wensing and Park, IEEE T-RO 36(1), 2020.
///
/// @returns infinity where J or J0 is not positive definite.
double entropic_divergence(const Eigen::Matrix4d& J, const Eigen::Matrix4d& J0);

}  // namespace veridyn
