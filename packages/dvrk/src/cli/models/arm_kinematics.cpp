#include "cli/models/arm_kinematics.hpp"

#include <algorithm>
#include <memory>

#include "dvrk/arms/arm_facts.hpp"
#include "dvrk/arms/arm_kinematics.hpp"

namespace veridyn::cli {
namespace {

const char* describe(dvrk::InverseStatus status) {
  switch (status) {
    case dvrk::InverseStatus::kDone:
      return "reached";
    case dvrk::InverseStatus::kOutsideLimits:
      return "outside limits";
    case dvrk::InverseStatus::kSingular:
      return "singular";
    case dvrk::InverseStatus::kOutOfReach:
      return "out of reach";
  }
  return "";
}

template <typename Kinematics>
KinematicsExtension::InverseSolver solver_of(const dvrk::ArmFacts& facts) {
  const auto closed = std::make_shared<Kinematics>(facts);
  return [closed](const Eigen::Isometry3d& T_base_tip, VectorXd& q) -> std::string {
    const typename Kinematics::Joints near = q;
    const auto solution = closed->inverse(T_base_tip.matrix(), near);
    q = solution.q;
    return describe(solution.status);
  };
}

KinematicsExtension::InverseSolver closed_form(const dvrk::ArmFacts& facts) {
  if (facts.kind == "PSM") return solver_of<dvrk::PsmKinematics>(facts);
  if (facts.kind == "ECM") return solver_of<dvrk::EcmKinematics>(facts);
  if (facts.kind == "MTM") return solver_of<dvrk::MtmKinematics>(facts);
  return {};
}

std::optional<KinematicsExtension::Arm> read(const std::string& name) {
  const std::vector<std::string> known = dvrk::arm_names();
  if (std::find(known.begin(), known.end(), name) == known.end()) return std::nullopt;
  const dvrk::ArmFacts facts = dvrk::read_arm(name);
  return KinematicsExtension::Arm{dvrk::arm_model(facts), closed_form(facts)};
}

}  // namespace

KinematicsExtension dvrk_kinematics() {
  return {", or an arm of the dVRK by its closed form: PSM1, MTMR, ECM", read};
}

}  // namespace veridyn::cli
