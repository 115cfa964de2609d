#include "cli/models/kinematics_closed_form.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "cli/options/option_checks.hpp"
#include "dvrk/arms/arm_facts.hpp"
#include "dvrk/arms/arm_kinematics.hpp"
#include "veridyn/model/model_file.hpp"

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
InverseSolver solver_of(const dvrk::ArmFacts& facts) {
  const auto closed = std::make_shared<Kinematics>(facts);
  return [closed](const Eigen::Isometry3d& T_base_tip, VectorXd& q) -> std::string {
    const typename Kinematics::Joints near = q;
    const auto solution = closed->inverse(T_base_tip.matrix(), near);
    q = solution.q;
    return describe(solution.status);
  };
}

InverseSolver closed_form(const dvrk::ArmFacts& facts) {
  if (facts.kind == "PSM") return solver_of<dvrk::PsmKinematics>(facts);
  if (facts.kind == "ECM") return solver_of<dvrk::EcmKinematics>(facts);
  if (facts.kind == "MTM") return solver_of<dvrk::MtmKinematics>(facts);
  return {};
}

std::string chosen(const Model& model, const std::string& asked) {
  if (!asked.empty()) {
    expect_one_of("--frame", asked, frame_names(model));
    return asked;
  }
  for (const char* usual : {"tip", "tool"}) {
    if (model.find_frame(usual) >= 0) return usual;
  }
  return model.frames().back().name;
}

}  // namespace

Arm read_kinematic_arm(const std::string& robot, const std::string& frame) {
  const std::vector<std::string> known = dvrk::arm_names();
  if (std::find(known.begin(), known.end(), robot) == known.end()) {
    Model model = read_model(robot);
    std::string at = chosen(model, frame);
    return {std::move(model), std::move(at), {}};
  }
  const dvrk::ArmFacts facts = dvrk::read_arm(robot);
  Model model = dvrk::arm_model(facts);
  std::string at = chosen(model, frame);
  const bool of_tip = at == "tip";
  return {std::move(model), std::move(at), of_tip ? closed_form(facts) : InverseSolver{}};
}

}  // namespace veridyn::cli
