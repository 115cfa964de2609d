#include "cli/models/arm_kinematics.hpp"

#include <algorithm>
#include <memory>

#include "dvrk/arms/arm_facts.hpp"
#include "dvrk/arms/arm_kinematics.hpp"

namespace veridyn::cli {
namespace {

ReachStatus reach_status(dvrk::InverseStatus status) {
  switch (status) {
    case dvrk::InverseStatus::kDone:
      return ReachStatus::kReached;
    case dvrk::InverseStatus::kOutsideLimits:
      return ReachStatus::kOutsideLimits;
    case dvrk::InverseStatus::kSingular:
      return ReachStatus::kSingular;
    case dvrk::InverseStatus::kOutOfReach:
      return ReachStatus::kOutOfReach;
  }
  return ReachStatus::kNotReached;
}

template <typename Kinematics>
KinematicsExtension::InverseSolver make_solver(const dvrk::ArmFacts& facts) {
  const auto closed = std::make_shared<Kinematics>(facts);
  return [closed](const Eigen::Isometry3d& T_base_tip, VectorXd& q) {
    const typename Kinematics::Joints near = q;
    const auto solution = closed->inverse(T_base_tip.matrix(), near);
    q = solution.q;
    return reach_status(solution.status);
  };
}

// Solver of the closed form of the arm's kind; empty for other kinds.
KinematicsExtension::InverseSolver closed_form_solver(const dvrk::ArmFacts& facts) {
  if (facts.kind == "PSM") return make_solver<dvrk::PsmKinematics>(facts);
  if (facts.kind == "ECM") return make_solver<dvrk::EcmKinematics>(facts);
  if (facts.kind == "MTM") return make_solver<dvrk::MtmKinematics>(facts);
  return {};
}

// The arm of this name; nullopt if it is not known.
std::optional<KinematicsExtension::Arm> read_known_arm(const std::string& name) {
  const std::vector<std::string> known = dvrk::arm_names();
  if (std::find(known.begin(), known.end(), name) == known.end()) return std::nullopt;
  const dvrk::ArmFacts facts = dvrk::read_arm(name);
  return KinematicsExtension::Arm{dvrk::arm_model(facts), closed_form_solver(facts)};
}

}  // namespace

KinematicsExtension dvrk_kinematics() {
  return {", or an arm of the dVRK by its closed form: PSM1, MTMR, ECM", read_known_arm};
}

}  // namespace veridyn::cli
