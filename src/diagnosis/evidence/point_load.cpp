#include "diagnosis/evidence/point_load.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/evidence/clustered_fit.hpp"
#include "diagnosis/evidence/numerics.hpp"

namespace veridyn {
namespace {

InertialParameters point_mass(double mass, const Eigen::Vector3d& h) {
  InertialParameters phi;
  phi << mass, h, (h.y() * h.y() + h.z() * h.z()) / mass, -h.x() * h.y() / mass,
      (h.x() * h.x() + h.z() * h.z()) / mass, -h.x() * h.z() / mass, -h.y() * h.z() / mass,
      (h.x() * h.x() + h.y() * h.y()) / mass;
  return phi;
}

// Derivative of point_mass() by (ln m, h).
Eigen::Matrix<double, 10, 4> slopes(double mass, const Eigen::Vector3d& h) {
  Eigen::Matrix<double, 10, 4> J = Eigen::Matrix<double, 10, 4>::Zero();
  const InertialParameters phi = point_mass(mass, h);
  J(0, 0) = mass;
  J.block<6, 1>(4, 0) = -phi.segment<6>(4);
  for (int k = 0; k < 3; ++k) J(1 + k, 1 + k) = 1.0;
  const double x = h.x() / mass;
  const double y = h.y() / mass;
  const double z = h.z() / mass;
  J.block<6, 3>(4, 1) << 0.0, 2.0 * y, 2.0 * z,  // xx
      -y, -x, 0.0,                               // xy
      2.0 * x, 0.0, 2.0 * z,                     // yy
      -z, 0.0, -x,                               // xz
      0.0, -z, -y,                               // yz
      2.0 * x, 2.0 * y, 0.0;                     // zz
  return J;
}

// Levenberg and Marquardt from one start; the centre stays within `reach` of the frame.
PointLoad descend(const LoadCost& f, double mass, Eigen::Vector3d h, double reach) {
  const auto within = [&](const Eigen::Vector3d& moment, double of) -> Eigen::Vector3d {
    return moment.cwiseMin(of * reach).cwiseMax(-of * reach);
  };
  h = within(h, mass);
  PointLoad best{point_mass(mass, h), 0.0};
  best.cost = f.cost(best.phi);
  double damping = numerics::kFirstDamping;
  for (int step = 0; step < numerics::kDescentSteps; ++step) {
    const Eigen::Matrix<double, 10, 4> J = slopes(mass, h);
    const Eigen::Vector4d g = J.transpose() * (f.b - f.A * best.phi);
    Eigen::Matrix4d H = J.transpose() * f.A * J;
    const Eigen::Vector4d scale =
        H.diagonal().cwiseMax(numerics::kNoise * H.diagonal().maxCoeff() + numerics::kTiny);
    H.diagonal() += damping * scale;
    const Eigen::Vector4d d = RidgedSolver(H).solve(g);
    const double next_mass = std::clamp(mass * std::exp(std::clamp(d[0], -1.0, 1.0)),
                                        numerics::kLightest, numerics::kHeaviest);
    const Eigen::Vector3d next_h = within(h + d.tail<3>(), next_mass);
    const InertialParameters phi = point_mass(next_mass, next_h);
    const double cost = f.cost(phi);
    if (!(cost < best.cost)) {
      damping *= numerics::kMoreDamping;
      if (damping > numerics::kMostDamping) break;
      continue;
    }
    const bool small = best.cost - cost < numerics::kConverged * std::abs(cost);
    mass = next_mass;
    h = next_h;
    best = {phi, cost};
    damping = std::max(damping * numerics::kLessDamping, numerics::kNoise);
    if (small) break;
  }
  return best;
}

}  // namespace

std::vector<PointLoad> all_point_loads(const LoadCost& f, const Eigen::Vector3d& h, double reach) {
  std::vector<PointLoad> out;
  for (const double mass : numerics::kFirstMasses) {
    for (const double share : {1.0, numerics::kFirstPlaces, -numerics::kFirstPlaces})
      out.push_back(descend(f, mass, share * h, reach));
  }
  return out;
}

PointLoad fit_point_load(const LoadCost& f, const PointLoad* near, double reach) {
  if (near != nullptr) return descend(f, near->mass(), near->moment(), reach);
  const Eigen::Vector3d h = RidgedSolver(f.A.block(1, 1, 3, 3)).solve(f.b.segment(1, 3));
  PointLoad best;
  for (const PointLoad& s : all_point_loads(f, h, reach)) {
    if (s.cost < best.cost) best = s;
  }
  return best;
}

Eigen::Matrix<double, 6, 1> load_extent(const LoadCost& f, const PointLoad& s) {
  MatrixXd A = f.A.bottomRightCorner(6, 6);
  A.diagonal() *= 1.0 + numerics::kLoadPrior;
  return RidgedSolver(A).solve((f.b - f.A * s.phi).tail(6));
}

std::array<bool, 3> seen_directions(const LoadCost& f, const PointLoad& at) {
  const Eigen::Matrix<double, 10, 4> J = slopes(at.mass(), at.moment());
  const Eigen::Vector4d curvature = (J.transpose() * f.A * J).diagonal();
  const double most = curvature.tail<3>().maxCoeff();
  std::array<bool, 3> out{};
  for (size_t k = 0; k < out.size(); ++k)
    out[k] = curvature[static_cast<Eigen::Index>(k) + 1] > 2.0 * numerics::kUnseenLoad * most;
  return out;
}

}  // namespace veridyn
