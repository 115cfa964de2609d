#include "calibration/links/link_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "model/expression.hpp"
#include "model/joint_placement.hpp"

namespace veridyn::internal {
namespace {

using EntryKind = LinkEntry::Kind;
using Kind = LinkParameter::Kind;

constexpr double kStep = 1e-6;  // step of the differences in a constant

const char* entry_name(EntryKind kind) {
  static const char* const kNames[] = {"a", "alpha", "d",     "theta", "x",
                                       "y", "z",     "roll",  "pitch", "yaw"};
  return kNames[static_cast<int>(kind)];
}

bool is_angle(EntryKind kind) {
  return kind == EntryKind::kAlpha || kind == EntryKind::kTheta || kind == EntryKind::kRoll ||
         kind == EntryKind::kPitch || kind == EntryKind::kYaw;
}

// Lengths before angles: among confounded constants the first is named.
int rank(EntryKind kind) {
  switch (kind) {
    case EntryKind::kA:
    case EntryKind::kD:
    case EntryKind::kX:
    case EntryKind::kY:
    case EntryKind::kZ: return 0;
    case EntryKind::kTheta: return 1;
    case EntryKind::kRatio: return 3;
    default: return 2;
  }
}

bool mentions(const std::string& formula, const std::string& name) {
  for (std::size_t at = formula.find(name); at != std::string::npos;
       at = formula.find(name, at + 1)) {
    const auto word = [&](std::size_t k) {
      return k < formula.size() && (std::isalnum(static_cast<unsigned char>(formula[k])) != 0 ||
                                    formula[k] == '_');
    };
    if ((at == 0 || !word(at - 1)) && !word(at + name.size())) return true;
  }
  return false;
}

}  // namespace

LinkParameters::LinkParameters(const Model& arm, int frame, bool base_free, bool tool_free,
                               bool oriented)
    : arm_(arm) {
  for (int k = frame; k >= 0; k = arm.frames()[k].parent)
    path_.insert(path_.begin(), k);
  collect_entries();
  collect_parameters(base_free, tool_free, oriented);
}

void LinkParameters::collect_entries() {
  const auto& formulas = arm_.description().formulas;
  const auto add = [&](int frame, EntryKind kind, int coordinate, double value,
                       const std::string& place) {
    const auto formula = formulas.find(place);
    entries_.push_back({frame, kind, coordinate, value,
                        formula == formulas.end() ? "" : formula->second});
  };
  for (const int k : path_) {
    const Frame& frame = arm_.frames()[k];
    const std::string place = "frames/" + frame.name;
    if (frame.dh) {
      add(k, EntryKind::kA, -1, frame.dh->a, place + "/dh/0");
      add(k, EntryKind::kAlpha, -1, frame.dh->alpha, place + "/dh/1");
      add(k, EntryKind::kD, -1, frame.dh->d, place + "/dh/2");
      add(k, EntryKind::kTheta, -1, frame.dh->theta, place + "/dh/3");
    } else {
      const JointPlacement placed = joint_placement(frame);
      const Vec3d rpy = rpy_from_rotation(placed.origin.R);
      const double values[] = {placed.origin.p.x, placed.origin.p.y, placed.origin.p.z,
                               rpy.x,             rpy.y,             rpy.z};
      for (int c = 0; c < 6; ++c)
        add(k, static_cast<EntryKind>(static_cast<int>(EntryKind::kX) + c), -1, values[c],
            place + (c < 3 ? "/origin/xyz/" : "/origin/rpy/") + std::to_string(c % 3));
    }
    const std::string joint = frame.type == JointType::kRevolute ? "/revolute/" : "/prismatic/";
    for (int i = 0; i < arm_.joints(); ++i) {
      const double c = frame.variable.coefficients[i];
      if (c == 0.0) continue;
      add(k, EntryKind::kRatio, i, c,
          place + joint + arm_.coordinates()[i].name);
    }
  }
}

void LinkParameters::collect_parameters(bool base_free, bool tool_free, bool oriented) {
  static const char* const kPose[] = {"rx", "ry", "rz", "x", "y", "z"};
  for (int c = 0; c < 6; ++c) {
    const std::string unit = c < 3 ? "rad" : "m";
    if (base_free) all_.push_back({Kind::kBase, c, std::string("base ") + kPose[c], "", unit, 0.0});
  }
  for (int c = oriented ? 0 : 3; c < 6; ++c) {
    const std::string unit = c < 3 ? "rad" : "m";
    if (tool_free) all_.push_back({Kind::kTool, c, std::string("tool ") + kPose[c], "", unit, 0.0});
  }
  // Includes constants of other branches, which have no effect here.
  for (const auto& [name, value] : arm_.description().constants) {
    bool angle = false;
    bool places = false;
    for (const auto& [place, formula] : arm_.description().formulas)
      places = places || (place.compare(0, 7, "frames/") == 0 && mentions(formula, name));
    for (const LinkEntry& e : entries_)
      angle = angle || (is_angle(e.kind) && mentions(e.formula, name));
    const auto own = arm_.description().formulas.find("constants/" + name);
    angle = angle || (own != arm_.description().formulas.end() && mentions(own->second, "atan"));
    if (places) all_.push_back({Kind::kConstant, 0, name, "", angle ? "rad" : "1", value});
  }
  std::vector<int> order;
  for (int k = 0; k < static_cast<int>(entries_.size()); ++k) order.push_back(k);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return rank(entries_[a].kind) <
           rank(entries_[b].kind);
  });
  for (const int k : order) {
    const LinkEntry& e = entries_[k];
    const std::string& frame = arm_.frames()[e.frame].name;
    if (e.kind != EntryKind::kRatio) {
      all_.push_back({Kind::kEntry, k, entry_name(e.kind), frame, is_angle(e.kind) ? "rad" : "m",
                      e.value});
    } else if (std::abs(e.value) != 1.0) {  // a joint that drives its own frame has no ratio
      const std::string& joint = arm_.coordinates()[e.coordinate].name;
      all_.push_back({Kind::kEntry, k, "ratio of " + joint, frame, "1", e.value});
    }
  }
  std::set<int> used;
  for (const LinkEntry& e : entries_) {
    if (e.kind == EntryKind::kRatio) used.insert(e.coordinate);
  }
  for (const int i : used) {
    const Coordinate& c = arm_.coordinates()[i];
    all_.push_back({Kind::kZero, i, "zero of " + c.name, "", c.prismatic ? "m" : "rad",
                    c.recorded.position_offset});
  }
}

std::map<std::string, double> LinkParameters::constants(const VectorRef& x) const {
  std::map<std::string, double> out = arm_.description().constants;
  std::set<std::string> set;
  for (int k = 0; k < size(); ++k) {
    const LinkParameter& p = all_[k];
    if (p.kind != Kind::kConstant || x[k] == 0.0) continue;
    out[p.name] = p.file + x[k];
    set.insert(p.name);
  }
  if (set.empty()) return out;
  // Recomputes constants that depend on others; a chain of n needs n rounds.
  for (std::size_t round = 0; round < out.size(); ++round) {
    for (auto& [name, value] : out) {
      const auto formula = arm_.description().formulas.find("constants/" + name);
      if (set.count(name) == 0 && formula != arm_.description().formulas.end())
        value = veridyn::evaluate(formula->second, out);
    }
  }
  return out;
}

double LinkParameters::entry_value(const LinkEntry& entry,
                                   const std::map<std::string, double>& c) const {
  return entry.formula.empty() ? entry.value : veridyn::evaluate(entry.formula, c);
}

void LinkParameters::evaluate(const VectorRef& x, VectorXd& values, MatrixXd* by_constant) const {
  const auto count = static_cast<Eigen::Index>(entries_.size());
  const std::map<std::string, double> c = constants(x);
  values.resize(count);
  for (Eigen::Index k = 0; k < count; ++k)
    values[k] = entry_value(entries_[k], c);
  if (by_constant != nullptr) *by_constant = MatrixXd::Zero(count, size());
  for (int p = 0; p < size(); ++p) {
    const LinkParameter& parameter = all_[p];
    if (parameter.kind == Kind::kEntry) values[parameter.index] += x[p];
    if (parameter.kind != Kind::kConstant || by_constant == nullptr) continue;
    VectorXd up = x;
    VectorXd down = x;
    up[p] += kStep;
    down[p] -= kStep;
    const std::map<std::string, double> high = constants(up);
    const std::map<std::string, double> low = constants(down);
    for (Eigen::Index k = 0; k < count; ++k) {
      const LinkEntry& e = entries_[k];
      if (e.formula.empty()) continue;
      (*by_constant)(k, p) = (entry_value(e, high) - entry_value(e, low)) / (2.0 * kStep);
    }
  }
}

Model LinkParameters::applied(const VectorRef& x) const {
  ModelDescription d = arm_.description();
  // Frames off the path depend on the named constants too.
  const std::map<std::string, double> c = constants(x);
  d.constants = c;
  const auto at = [&](const std::string& place, double otherwise) {
    const auto formula = d.formulas.find(place);
    return formula == d.formulas.end() ? otherwise : veridyn::evaluate(formula->second, c);
  };
  for (Frame& frame : d.frames) {
    const std::string place = "frames/" + frame.name;
    for (int i = 0; i < arm_.joints(); ++i) {
      double& ratio = frame.variable.coefficients[i];
      const std::string joint = frame.type == JointType::kRevolute ? "/revolute/" : "/prismatic/";
      if (ratio != 0.0)
        ratio = at(place + joint + d.coordinates[i].name, ratio);
    }
    if (!frame.dh) continue;
    frame.dh->a = at(place + "/dh/0", frame.dh->a);
    frame.dh->alpha = at(place + "/dh/1", frame.dh->alpha);
    frame.dh->d = at(place + "/dh/2", frame.dh->d);
    frame.dh->theta = at(place + "/dh/3", frame.dh->theta);
  }
  VectorXd values;
  evaluate(x, values, nullptr);
  std::map<int, JointPlacement> placed;
  std::map<int, Vec3d> turns;
  for (std::size_t k = 0; k < entries_.size(); ++k) {
    const LinkEntry& e = entries_[k];
    Frame& frame = d.frames[e.frame];
    const double value = values[static_cast<Eigen::Index>(k)];
    if (!frame.dh && placed.count(e.frame) == 0) placed[e.frame] = joint_placement(frame);
    switch (e.kind) {
      case EntryKind::kA: frame.dh->a = value; break;
      case EntryKind::kAlpha: frame.dh->alpha = value; break;
      case EntryKind::kD: frame.dh->d = value; break;
      case EntryKind::kTheta: frame.dh->theta = value; break;
      case EntryKind::kX: placed[e.frame].origin.p.x = value; break;
      case EntryKind::kY: placed[e.frame].origin.p.y = value; break;
      case EntryKind::kZ: placed[e.frame].origin.p.z = value; break;
      case EntryKind::kRoll: turns[e.frame].x = value; break;
      case EntryKind::kPitch: turns[e.frame].y = value; break;
      case EntryKind::kYaw: turns[e.frame].z = value; break;
      case EntryKind::kRatio: frame.variable.coefficients[e.coordinate] = value; break;
    }
  }
  for (Frame& frame : d.frames) {
    if (!frame.dh) continue;
    const DhRow row = *frame.dh;
    frame.variable.offset = 0.0;
    place(frame, row);
  }
  for (auto& [k, placement] : placed) {
    placement.origin.R = rotation_from_rpy(turns[k]);
    place(d.frames[k], placement);
  }
  for (int p = 0; p < size(); ++p) {
    const LinkParameter& parameter = all_[p];
    if (parameter.kind == Kind::kZero)
      d.coordinates[parameter.index].recorded.position_offset += x[p];
  }
  // Values identified with the old geometry keep their numbers and lose their statistics.
  d.identified.reset();
  return Model(std::move(d));
}

}  // namespace veridyn::internal
