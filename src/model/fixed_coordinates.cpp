#include "veridyn/model/fixed_coordinates.hpp"

#include <algorithm>
#include <cmath>

#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

namespace veridyn {
namespace {

// The axis without the fixed coordinates, whose contribution goes into its offset.
Axis reduced(const Axis& axis, const VectorXd& position, const std::vector<int>& kept) {
  Axis out;
  out.offset = axis.offset;
  out.coefficients.resize(static_cast<Eigen::Index>(kept.size()));
  for (std::size_t k = 0; k < kept.size(); ++k)
    out.coefficients[static_cast<Eigen::Index>(k)] = axis.coefficients[kept[k]];
  std::size_t next = 0;
  for (Eigen::Index i = 0; i < axis.coefficients.size(); ++i) {
    if (next < kept.size() && kept[next] == i) {
      ++next;
    } else {
      out.offset += axis.coefficients[i] * position[i];
    }
  }
  return out;
}

bool moves(const Axis& axis) {
  return (axis.coefficients.array() != 0.0).any();
}

// Turns a locked joint into a fixed frame: T = A J(s0) B.
void hold(Frame* frame) {
  const bool turns = frame->type == JointType::kRevolute;
  const double s = frame->variable.offset;
  const Posed J = turns ? Posed{rotation_z(s), {0, 0, 0}} : Posed{identity3(), {0, 0, s}};
  frame->A = frame->A * J * frame->B;
  frame->B = identity_pose();
  frame->type = JointType::kFixed;
  frame->variable.offset = 0.0;
  frame->dh.reset();
}

}  // namespace

Model with_fixed(const Model& arm, const std::map<std::string, double>& positions) {
  if (positions.empty()) return arm;
  VectorXd position = VectorXd::Zero(arm.joints());
  std::vector<char> fixed(arm.joints(), 0);
  std::vector<std::string> names;
  for (const Coordinate& c : arm.coordinates()) names.push_back(c.name);
  for (const auto& [name, value] : positions) {
    const std::optional<JointIndex> i = arm.find_coordinate(name);
    require(i.has_value(), "found joint '", name, "'", did_you_mean(name, names), ", expected one of ",
            arm.name(), ": ", listed(names), ".");
    position[i->value] = value;
    fixed[i->value] = 1;
  }
  ModelDescription d = arm.description();
  std::vector<int> kept;
  std::vector<Coordinate> coordinates;
  for (int i = 0; i < arm.joints(); ++i) {
    if (fixed[i] != 0) continue;
    kept.push_back(i);
    coordinates.push_back(d.coordinates[i]);
  }
  for (Coordinate& c : coordinates) {
    std::map<JointIndex, double> crosstalk;
    for (const auto& [from, share] : c.recorded.torque_crosstalk) {
      require(fixed[from.value] == 0, "found joint '", names[from.value], "' fixed, expected it to move: the recorded torque of joint '",
              c.name, "' contains ", share, " times its torque.");
      crosstalk[{static_cast<int>(std::count(fixed.begin(), fixed.begin() + from.value, 0))}] = share;
    }
    c.recorded.torque_crosstalk = std::move(crosstalk);
  }
  require(!kept.empty(), "found all joints of ", arm.name(), " fixed, expected one that moves.");
  d.coordinates = std::move(coordinates);
  for (Frame& frame : d.frames) {
    const bool moved = moves(frame.variable);
    frame.variable = reduced(frame.variable, position, kept);
    if (moved && !moves(frame.variable)) hold(&frame);
  }
  std::vector<EffectTerm> effects;
  for (EffectTerm term : d.effects) {
    const bool payload = !term.frame.empty();
    term.axis = reduced(term.axis, position, kept);
    if (term.from) term.from = reduced(*term.from, position, kept);
    const bool idle = (!payload && !moves(term.axis)) || (term.from && !moves(*term.from));
    if (!idle) effects.push_back(std::move(term));
  }
  d.effects = std::move(effects);
  d.identified.reset();
  return Model(std::move(d));
}

Model with_drive_gains(const Model& arm, const std::vector<double>& gains) {
  require(gains.size() == arm.coordinates().size(), "found ", gains.size(),
          " drive gains, expected one for each of the ", arm.joints(), " joints of '", arm.name(), "'.");
  ModelDescription d = arm.description();
  for (size_t i = 0; i < gains.size(); ++i) {
    require(std::isfinite(gains[i]) && gains[i] != 0.0, "found the drive gain ", gains[i], " of ",
            d.coordinates[i].name, ", expected one that is not zero.");
    d.coordinates[i].drive_gain = gains[i];
    d.coordinates[i].drive_gain_deviation = 0.0;
  }
  return Model(std::move(d));
}

}  // namespace veridyn
