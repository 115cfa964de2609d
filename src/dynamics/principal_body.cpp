#include "dynamics/principal_body.hpp"

#include <Eigen/Eigenvalues>

#include "math/eigen_pose.hpp"

namespace veridyn {
namespace {

constexpr double kRounding = 1e-9;  // threshold relative to the largest principal moment

}  // namespace

bool PrincipalBody::possible() const {
  return moments[0] > 0.0 && moments[0] + moments[1] >= moments[2] * (1.0 - kRounding);
}

PrincipalBody principal_body(const double* phi, const Posed& B) {
  const double m = phi[0];
  const Eigen::Vector3d c = Eigen::Vector3d(phi[1], phi[2], phi[3]) / m;
  Eigen::Matrix3d L;
  L << phi[4], phi[5], phi[7], phi[5], phi[6], phi[8], phi[7], phi[8], phi[9];
  const Eigen::Matrix3d about_com =
      L - m * (c.dot(c) * Eigen::Matrix3d::Identity() - c * c.transpose());
  const Eigen::Matrix3d R = eigen(B.R);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(R * about_com * R.transpose());
  Eigen::Matrix3d axes = principal.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) *= -1;
  return {R * c + Eigen::Vector3d(B.p.x, B.p.y, B.p.z), axes, principal.eigenvalues()};
}

}  // namespace veridyn
