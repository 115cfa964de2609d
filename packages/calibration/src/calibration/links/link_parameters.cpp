#include "calibration/links/link_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "veridyn/effects/kinematic_error.hpp"
#include "veridyn/files/expression.hpp"

namespace veridyn::internal {
namespace {

using Kind = LinkParameter::Kind;

constexpr double kStep = 1e-6;  // step of the differences in a constant

bool is_angle(const FrameConstant& constant) { return unit_of(constant) == "rad"; }

// Order of constants with one effect, of which the first is reported: lengths before angles, ratios last.
int reporting_order(const FrameConstant& constant) {
  if (constant.joint) return 3;
  if (!is_angle(constant)) return 0;
  return constant.number == FrameNumber::kTheta ? 1 : 2;
}

// True if the formula has `name` as a whole word.
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

LinkParameters::LinkParameters(const Model& arm, FrameIndex frame, bool base_free, bool tool_free,
                               bool oriented)
    : arm_(arm) {
  for (std::optional<FrameIndex> k = frame; k; k = arm.frames()[k->value].parent)
    path_.insert(path_.begin(), k->value);
  collect_entries();
  collect_parameters(base_free, tool_free, oriented);
}

void LinkParameters::collect_entries() {
  const auto& formulas = arm_.description().formulas;
  for (const int k : path_) {
    for (const FrameConstant& constant : constants_of(arm_, {k})) {
      const auto formula = formulas.find(formula_key(arm_, constant));
      entries_.push_back({constant, value_of({constant}, arm_.description()),
                          formula == formulas.end() ? "" : formula->second});
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
      angle = angle || (is_angle(e.constant) && mentions(e.formula, name));
    const auto own = arm_.description().formulas.find("constants/" + name);
    angle = angle || (own != arm_.description().formulas.end() && mentions(own->second, "atan"));
    if (places) all_.push_back({Kind::kConstant, 0, name, "", angle ? "rad" : "1", value});
  }
  std::vector<int> order;
  for (int k = 0; k < static_cast<int>(entries_.size()); ++k) order.push_back(k);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return reporting_order(entries_[a].constant) < reporting_order(entries_[b].constant);
  });
  for (const int k : order) {
    const LinkEntry& e = entries_[k];
    // The coefficient of a joint that drives its own frame is no gear ratio.
    if (e.constant.joint && std::abs(e.value) == 1.0) continue;
    all_.push_back({Kind::kEntry, k, name_of(arm_, e.constant),
                    arm_.frames()[e.constant.frame.value].name, unit_of(e.constant), e.value});
  }
  std::set<int> used;
  for (const LinkEntry& e : entries_) {
    if (e.constant.joint) used.insert(e.constant.joint->value);
  }
  for (const int i : used) {
    const Coordinate& c = arm_.coordinates()[i];
    all_.push_back({Kind::kZero, i, "zero of " + c.name, "", c.prismatic ? "m" : "rad",
                    c.recorded.position_offset});
  }
}

// Named constants of the file at the parameters x, including those that depend on others.
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
  // Recomputes constants that depend on others; a chain of n constants needs n rounds.
  for (std::size_t round = 0; round < out.size(); ++round) {
    for (auto& [name, value] : out) {
      const auto formula = arm_.description().formulas.find("constants/" + name);
      if (set.count(name) == 0 && formula != arm_.description().formulas.end())
        value = veridyn::evaluate(formula->second, out);
    }
  }
  return out;
}

// Value of an entry with the named constants c.
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

Model LinkParameters::arm_with(const VectorRef& x) const {
  ModelDescription d = arm_.description();
  d.constants = constants(x);
  std::vector<std::pair<FrameConstant, double>> set;
  // Frames that are not on the path depend on the named constants too.
  for (int k = 0; k < static_cast<int>(d.frames.size()); ++k) {
    for (const FrameConstant& constant : constants_of(arm_, {k})) {
      const auto formula = d.formulas.find(formula_key(arm_, constant));
      if (formula != d.formulas.end())
        set.emplace_back(constant, veridyn::evaluate(formula->second, d.constants));
    }
  }
  VectorXd values;
  evaluate(x, values, nullptr);
  for (std::size_t k = 0; k < entries_.size(); ++k) set.emplace_back(entries_[k].constant, values[k]);
  set_values(set, d);
  for (int p = 0; p < size(); ++p) {
    const LinkParameter& parameter = all_[p];
    if (parameter.kind == Kind::kZero)
      d.coordinates[parameter.index].recorded.position_offset += x[p];
  }
  // Values identified with the old geometry are kept, but their statistics are dropped.
  d.identified.reset();
  return Model(std::move(d));
}

}  // namespace veridyn::internal
