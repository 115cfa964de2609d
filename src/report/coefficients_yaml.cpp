#include <fmt/format.h>

#include "veridyn/report/motion_json.hpp"

namespace veridyn {
namespace {

std::string yaml_list(const VectorXd& values) {
  std::string out;
  for (const double value : values) out += fmt::format("{}{:.17g}", out.empty() ? "" : ", ", value);
  return "[" + out + "]";
}

}  // namespace

std::string coefficients_yaml(const Excitation& e) {
  std::string out =
      "# q(t) = q0 + sum over l of a_l / (w l) sin(w l t) - b_l / (w l) cos(w l t), w = 2 pi "
      "frequency\n"
      "# [rad, m, s]; the arm rests at t = 0 and at the end of every period.\n"
      "veridyn: 1\n";
  out += fmt::format("robot: {}\nfrequency: {:.17g}\nharmonics: {}\nperiods: {}\njoints:\n",
                     e.robot, e.trajectory.frequency(), e.trajectory.harmonics(), e.periods);
  for (Eigen::Index i = 0; i < e.trajectory.joints(); ++i) {
    out += fmt::format("  - name: {}\n    q0: {:.17g}\n    a: {}\n    b: {}\n",
                       e.joints[i], e.trajectory.q0()[i],
                       yaml_list(e.trajectory.a().row(i)), yaml_list(e.trajectory.b().row(i)));
  }
  return out;
}

}  // namespace veridyn
