#include "veridyn/files/physical_faults.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>

#include "files/physical_body.hpp"

namespace veridyn {
namespace {

constexpr double kRoundedDigits = 0.01;  // relative tolerance; files print moments with about three digits

bool moves_at_all(const Model& arm, FrameIndex frame) {
  for (int i = 0; i < arm.joints(); ++i) {
    if (arm.moves(frame, {i})) return true;
  }
  return false;
}

}  // namespace

std::string body_fault(const std::string& name, const InertialParameters& phi) {
  const std::optional<PhysicalBody> body = physical_body(phi);
  if (!body) {
    return phi.isZero() ? "" : fmt::format("'{}' has moments of inertia and no mass", name);
  }
  Eigen::Matrix3d inertia;
  inertia << body->inertia[0], body->inertia[1], body->inertia[3], body->inertia[1],
      body->inertia[2], body->inertia[4], body->inertia[3], body->inertia[4], body->inertia[5];
  const Eigen::Vector3d moments =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
  const double rounding = kRoundedDigits * moments[2];
  if (moments[0] >= -rounding && moments[2] <= moments[0] + moments[1] + rounding) return "";
  return fmt::format(
      "'{}' has principal moments of inertia of {:.3g}, {:.3g} and {:.3g} kg m^2 about its centre of "
      "mass; in a body none is negative, and none exceeds the sum of the other two",
      name, moments[0], moments[1], moments[2]);
}

std::vector<std::string> physical_faults(const Model& arm) {
  std::vector<std::string> faults;
  if (arm.bodies().empty()) faults.push_back("no link has a body");
  for (const auto [k] : arm.bodies()) {
    const Frame& frame = arm.frames()[k];
    if (!frame.body->phi || !moves_at_all(arm, {k})) continue;
    const std::string fault = body_fault(frame.name, *frame.body->phi);
    if (!fault.empty()) faults.push_back(fault);
  }
  if (arm.bodies().empty() || !arm.inertial_values()) return faults;
  for (int i = 0; i < arm.joints(); ++i) {
    double mass = 0.0;
    for (const auto [k] : arm.bodies()) {
      if (arm.moves({k}, {i})) mass += (*arm.frames()[k].body->phi)[0];
    }
    if (!(mass > 0.0))
      faults.push_back(fmt::format("'{}' moves no mass",
                                   arm.coordinates()[i].name));
  }
  return faults;
}

}  // namespace veridyn
