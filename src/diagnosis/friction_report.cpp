#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/mistakes.hpp"
#include "diagnosis/numerics.hpp"
#include "math/digits.hpp"
#include "math/median.hpp"
#include "veridyn/diagnosis/friction_study.hpp"

namespace veridyn {
namespace {

std::string words(FrictionState state) {
  switch (state) {
    case FrictionState::kConfirmed: return "confirmed by what was held out";
    case FrictionState::kNotConfirmed: return "NOT CONFIRMED by what was held out";
    case FrictionState::kNotSupported: return "not supported";
    case FrictionState::kCannotTell: break;
  }
  return "cannot tell";
}

std::string joined_names(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  return out;
}

// Speeds at which the curve is printed where no speed was held.
std::vector<double> some_speeds(const FrictionCurve& curve) {
  std::vector<double> out;
  const Eigen::Index count = curve.velocity.size(), step = std::max<Eigen::Index>(1, count / 6);
  for (Eigen::Index k = 0; k < count; k += step) out.push_back(curve.velocity[k]);
  return out;
}

// Half width of the confidence band [N m] or [N] at the tabulated velocity nearest to `speed`.
double half_width_at(const FrictionCurve& curve, double speed) {
  const VectorXd off = (curve.velocity.array() - speed).abs();
  Eigen::Index k = 0;
  off.minCoeff(&k);
  return curve.half_width[k];
}

std::string curve_table(const JointFrictionStudy& j) {
  std::string out = fmt::format("  {:>10} {:>10} {:>9}   {:>10} {:>9} {:>8}\n", j.unit + "/s", "curve " + j.effort,
                                "+- 95 %", "measured", "scatter", "for s");
  for (const double v : some_speeds(j.curve))
    out += fmt::format("  {:>10.4f} {:>10.3f} {:>9.3f}\n", v, j.curve.at(v), half_width_at(j.curve, v));
  if (j.speeds.empty()) return out + "  no speed is held for half a second\n";
  out += "  speeds that are held:\n";
  for (const FrictionAtSpeed& s : j.speeds)
    out += fmt::format("  {:>10.4f} {:>10.3f} {:>9.3f}   {:>10.3f} {:>9.3f} {:>8.1f}\n", s.velocity, j.curve.at(s.velocity),
                       half_width_at(j.curve, s.velocity), s.torque, s.deviation, s.seconds);
  return out;
}

std::string breakaway_line(const JointFrictionStudy& j, int direction) {
  std::vector<double> torques;
  for (const FrictionBreakaway& b : j.breakaways)
    if (b.direction == direction) torques.push_back(b.torque);
  if (torques.empty()) return "";
  const auto [least, most] = std::minmax_element(torques.begin(), torques.end());
  return fmt::format("  breaks away {} at {:+.3f} {} (median of {}; {:+.3f} to {:+.3f})\n",
                     direction > 0 ? "forwards" : "backwards", median(torques), j.effort, torques.size(), *least, *most);
}

}  // namespace

std::string FrictionStudy::report() const {
  const std::string mistakes = mistakes_text(diagnosis);
  if (!reason.empty()) return mistakes + robot + ": no friction curve: " + reason + "\n";
  std::string out = mistakes + fmt::format("{}: friction of {} joint{}", robot, joints.size(), joints.size() == 1 ? "" : "s");
  out += resting.empty() ? "\n" : fmt::format("; {} at rest and left out\n", joined_names(resting));
  out += "held out for the verdicts: " + joined_names(held_out) + "\n";
  for (const JointFrictionStudy& j : joints) {
    out += fmt::format("\njoint {} ({}): held-out error {} % with viscous and Coulomb friction, {} % with what is confirmed\n",
                       j.joint.value + 1, j.coordinate, in_percent(j.error_plain), in_percent(j.error));
    out += curve_table(j) + breakaway_line(j, 1) + breakaway_line(j, -1);
    for (const FrictionVerdict& v : j.verdicts) {
      out += fmt::format("  {:<28} {}", v.effect, words(v.state));
      if (v.p_value) out += fmt::format(" (p = {:.2g})", *v.p_value);
      out += ": " + v.words + "\n";
    }
  }
  return out;
}

}  // namespace veridyn
