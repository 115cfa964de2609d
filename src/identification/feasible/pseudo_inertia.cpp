#include "veridyn/identification/pseudo_inertia.hpp"
#include "math/numbers.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

namespace veridyn {

namespace {

double log_det(const Eigen::LLT<Eigen::Matrix4d>& factor) {
  return 2.0 * factor.matrixLLT().diagonal().array().log().sum();
}

}  // namespace

Eigen::Matrix4d pseudo_inertia(const Eigen::Ref<const InertialVector>& phi) {
  const double half_trace = 0.5 * (phi(4) + phi(6) + phi(9));
  Eigen::Matrix4d J;
  // clang-format off
  J << half_trace - phi(4), -phi(5),              -phi(7),              phi(1),
       -phi(5),             half_trace - phi(6),  -phi(8),              phi(2),
       -phi(7),             -phi(8),              half_trace - phi(9),  phi(3),
       phi(1),              phi(2),               phi(3),               phi(0);
  // clang-format on
  return J;
}

InertialVector pseudo_inertia_adjoint(const Eigen::Matrix4d& Z) {
  const double half_trace = 0.5 * (Z(0, 0) + Z(1, 1) + Z(2, 2));
  InertialVector phi;
  phi << Z(3, 3), Z(0, 3) + Z(3, 0), Z(1, 3) + Z(3, 1), Z(2, 3) + Z(3, 2),  //
      half_trace - Z(0, 0), -(Z(0, 1) + Z(1, 0)), half_trace - Z(1, 1),     //
      -(Z(0, 2) + Z(2, 0)), -(Z(1, 2) + Z(2, 1)), half_trace - Z(2, 2);
  return phi;
}

InertialVector inertial_parameters(const Eigen::Matrix4d& J) {
  const double trace = J(0, 0) + J(1, 1) + J(2, 2);
  InertialVector phi;
  phi << J(3, 3), J(0, 3), J(1, 3), J(2, 3),  //
      trace - J(0, 0), -J(0, 1), trace - J(1, 1), -J(0, 2), -J(1, 2), trace - J(2, 2);
  return phi;
}

InertialVector with_minimum_radius(const InertialVector& phi, double radius) {
  if (!(phi(0) > 0.0)) return InertialVector::Zero();
  Eigen::Matrix4d J = pseudo_inertia(phi);
  const Eigen::Vector3d h = phi.segment<3>(1);
  const Eigen::Matrix3d of_centre = h * h.transpose() / phi(0);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(J.topLeftCorner<3, 3>() - of_centre);
  const double least = phi(0) * radius * radius;
  if (eigen.eigenvalues()(0) >= least) return phi;
  J.topLeftCorner<3, 3>() = of_centre + eigen.eigenvectors() *
                                            eigen.eigenvalues().cwiseMax(least).asDiagonal() *
                                            eigen.eigenvectors().transpose();
  return inertial_parameters(J);
}

Eigen::Matrix4d principal_moment_matrix(const Eigen::Ref<const InertialVector>& phi) {
  Eigen::Matrix4d D;
  // clang-format off
  D << phi(4), phi(5), phi(7), 0.0,
       phi(5), phi(6), phi(8), 0.0,
       phi(7), phi(8), phi(9), 0.0,
       0.0,    0.0,    0.0,    phi(0);
  // clang-format on
  return D;
}

double smallest_eigenvalue(const Eigen::Matrix4d& J) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(J, Eigen::EigenvaluesOnly).eigenvalues()(0);
}

double smallest_scaled_eigenvalue(const Eigen::Matrix4d& J) {
  if (!(J.diagonal().minCoeff() > 0.0)) return -kInfinity;
  const Eigen::Vector4d scale = J.diagonal().cwiseSqrt().cwiseInverse();
  return smallest_eigenvalue(scale.asDiagonal() * J * scale.asDiagonal());
}

double entropic_divergence(const Eigen::Matrix4d& J, const Eigen::Matrix4d& J0) {
  const Eigen::LLT<Eigen::Matrix4d> factor(J);
  const Eigen::LLT<Eigen::Matrix4d> factor0(J0);
  if (factor.info() != Eigen::Success || factor0.info() != Eigen::Success) return kInfinity;
  return log_det(factor0) - log_det(factor) + factor0.solve(J).trace() - 4.0;
}

}  // namespace veridyn
