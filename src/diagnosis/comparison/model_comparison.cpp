#include "veridyn/diagnosis/model_comparison.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/comparison/comparison_statistics.hpp"
#include "diagnosis/comparison/comparison_words.hpp"
#include "diagnosis/comparison/matched_base.hpp"
#include "diagnosis/comparison/model_structure.hpp"
#include "diagnosis/comparison/standard_torque.hpp"
#include "math/numbers.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {
namespace {

// One of the two models with derived quantities.
struct Side {
  explicit Side(const Model& model) : arm(model), numbers(base_numbers(model)), torque(model) {}

  const Model& arm;
  BaseNumbers numbers;
  StandardTorque torque;

  // Parameters of the model that `keep` selects, the others zero.
  template <typename Keep>
  VectorXd values(Keep keep) const {
    VectorXd out(torque.parameters().size());
    for (size_t j = 0; j < torque.parameters().size(); ++j) {
      const StandardParameter& p = torque.parameters()[j];
      out[static_cast<Eigen::Index>(j)] = keep(p) ? p.value : 0.0;
    }
    return out;
  }

  // Standard parameters that correspond to these base parameters: each leading parameter has the value of its
  // base parameter, since their columns are equal; all others are zero.
  VectorXd standard_parameters_of(const VectorRef& base) const {
    VectorXd out = VectorXd::Zero(torque.parameters().size());
    for (size_t r = 0; r < numbers.leading.size(); ++r)
      out[numbers.leading[r]] = base[static_cast<Eigen::Index>(r)];
    return out;
  }

  // Unconstrained estimates; fixed parameters keep their values.
  VectorXd free_values() const {
    VectorXd out = standard_parameters_of(numbers.free);
    for (size_t j = 0; j < torque.parameters().size(); ++j) {
      if (numbers.clusters > 0 && torque.parameters()[j].fixed)
        out[static_cast<Eigen::Index>(j)] = torque.parameters()[j].value;
    }
    return out;
  }

  // Torque over the standard motion for one column of the scatter.
  MatrixXd chance(Eigen::Index column) const {
    return torque.torque(standard_parameters_of(numbers.scatter.col(column)));
  }
};

// (n) rms torque due to the scatter of both models.
VectorXd chance_difference(const Side& a, const Side& b, bool paired) {
  VectorXd sum = VectorXd::Zero(a.arm.joints());
  for (Eigen::Index c = 0; c < a.numbers.scatter.cols(); ++c)
    sum += rms(paired ? MatrixXd(b.chance(c) - a.chance(c)) : a.chance(c)).cwiseAbs2();
  for (Eigen::Index c = 0; c < b.numbers.scatter.cols() && !paired; ++c)
    sum += rms(b.chance(c)).cwiseAbs2();
  return sum.cwiseSqrt();
}

ComparedModel facts_of(const Side& side) {
  ComparedModel out;
  out.name = side.arm.name();
  out.clusters = side.numbers.clusters;
  out.note = side.numbers.note;
  if (const auto& identified = side.arm.description().identified) {
    out.recordings = identified->recordings;
    out.training_error = identified->error;
  }
  return out;
}

std::vector<TorqueDifference> torque_differences(const Side& a, const Side& b, bool paired) {
  const auto all = [](const StandardParameter&) { return true; };
  const auto bodies = [](const StandardParameter& p) { return !p.effect; };
  const auto effects = [](const StandardParameter& p) { return p.effect.has_value(); };
  const MatrixXd tau_a = a.torque.torque(a.values(all));
  const MatrixXd tau_b = b.torque.torque(b.values(all));
  const VectorXd rms_a = rms(tau_a);
  const VectorXd rms_b = rms(tau_b);
  const VectorXd difference = rms(tau_b - tau_a);
  const auto part = [&](const auto& keep) {
    return rms(b.torque.torque(b.values(keep)) - a.torque.torque(a.values(keep)));
  };
  const VectorXd of_bodies = part(bodies);
  const VectorXd of_effects = part(effects);
  const VectorXd chance = chance_difference(a, b, paired);
  const bool known = a.numbers.clusters > 0 || b.numbers.clusters > 0;
  std::vector<TorqueDifference> out;
  for (int i = 0; i < a.arm.joints(); ++i) {
    const Coordinate& c = a.arm.coordinates()[i];
    out.push_back({c.name, effort_unit(c), rms_a[i], rms_b[i], difference[i],
                   rms_a[i] > 0.0 ? difference[i] / rms_a[i] : kNaN, known ? chance[i] : kNaN,
                   of_bodies[i], of_effects[i]});
  }
  return out;
}

// The joint with the largest difference relative to its torque.
int main_joint(const VectorXd& torque, const std::vector<TorqueDifference>& joints) {
  int best = 0;
  double most = -1.0;
  for (size_t i = 0; i < joints.size(); ++i) {
    const double share = torque[static_cast<Eigen::Index>(i)] / std::max(joints[i].before, 1e-300);
    if (share <= most) continue;
    most = share;
    best = static_cast<int>(i);
  }
  return best;
}

ModelDifference parameter_difference(const MatchedParameter& m, const Side& a,
                                     const ClusterStatistics& how,
                                     const std::vector<TorqueDifference>& joints) {
  const auto row = static_cast<size_t>(m.row);
  const int standard = a.numbers.leading[row];
  const StandardParameter& p = a.torque.parameters()[standard];
  ModelDifference d;
  d.quantity = "parameter";
  d.name = a.numbers.names[row];
  d.expression = a.numbers.expressions[row];
  d.unit = a.numbers.units[row];
  d.before = m.before;
  d.after = m.after;
  add_statistics(m.scatter_before, m.scatter_after, how, d);
  d.torque = std::abs(d.difference) * a.torque.rms_of(standard);
  d.joint = {main_joint(d.torque, joints)};
  if (p.effect) {
    const EffectTerm& term = a.arm.effects()[*p.effect];
    d.effect = term.effect;
    d.joint = {main_coordinate(term.axis)};
  }
  d.coordinate = a.arm.coordinates()[d.joint.value].name;
  d.sentence = parameter_sentence(a.arm, a.torque, standard, d);
  return d;
}

const char* name_of(JointQuantity which) {
  static constexpr const char* kNames[] = {"friction", "offset", "weight", "weight_slope", "inertia"};
  return kNames[static_cast<int>(which)];
}

std::string unit_of(JointQuantity which, const Coordinate& coordinate) {
  if (which != JointQuantity::kInertia) return effort_unit(coordinate);
  return coordinate.prismatic ? "kg" : "kg m^2";
}

// The base parameter to which a quantity is proportional; empty if there are several.
std::string proportional_parameter(const Side& side, const VectorXd& u) {
  std::string found;
  for (size_t r = 0; r < side.numbers.leading.size(); ++r) {
    if (u[side.numbers.leading[r]] == 0.0) continue;
    if (!found.empty()) return "";
    found = side.numbers.expressions[r];
  }
  return found;
}

std::vector<ModelDifference> joint_differences(const Side& a, const Side& b,
                                               const ClusterStatistics& how) {
  const VectorXd free_a = a.free_values();
  const VectorXd free_b = b.free_values();
  std::vector<ModelDifference> out;
  for (int i = 0; i < a.arm.joints(); ++i) {
    for (const JointQuantity which : kJointQuantities) {
      const VectorXd u_a = a.torque.quantity(which, i);
      const VectorXd u_b = b.torque.quantity(which, i);
      const bool none_a = u_a.isZero(0.0), none_b = u_b.isZero(0.0);
      // A model without terms of friction does not say that there is none; `structure` names it.
      if (which == JointQuantity::kFriction ? none_a || none_b : none_a && none_b) continue;
      const Coordinate& coordinate = a.arm.coordinates()[i];
      ModelDifference d;
      d.quantity = name_of(which);
      d.unit = unit_of(which, coordinate);
      d.joint = {i};
      d.coordinate = coordinate.name;
      d.before = u_a.dot(free_a);
      d.after = u_b.dot(free_b);
      const auto scatter = [](const Side& side, const VectorXd& u) {
        VectorXd leading(side.numbers.leading.size());
        for (size_t r = 0; r < side.numbers.leading.size(); ++r)
          leading[static_cast<Eigen::Index>(r)] = u[side.numbers.leading[r]];
        return VectorXd(side.numbers.scatter.transpose() * leading);
      };
      add_statistics(scatter(a, u_a), scatter(b, u_b), how, d);
      d.same_as = proportional_parameter(a, u_a);
      d.sentence = joint_sentence(a.arm, which, d);
      out.push_back(std::move(d));
    }
  }
  return out;
}

double largest_share(const ModelDifference& d, const std::vector<TorqueDifference>& joints) {
  double most = 0.0;
  for (size_t i = 0; i < joints.size(); ++i)
    most =
        std::max(most, d.torque[static_cast<Eigen::Index>(i)] / std::max(joints[i].before, 1e-300));
  return most;
}

bool contains_expression(const std::vector<ModelDifference>& parameters, const std::string& expression) {
  return std::any_of(parameters.begin(), parameters.end(),
                     [&](const ModelDifference& d) { return d.expression == expression; });
}

}  // namespace

int ModelComparison::compared() const {
  const auto own = [](const ModelDifference& d) { return d.same_as.empty(); };
  return static_cast<int>(parameters.size()) +
         static_cast<int>(std::count_if(joints.begin(), joints.end(), own));
}

int ModelComparison::significant() const {
  const auto yes = [](const ModelDifference& d) { return d.significant && d.same_as.empty(); };
  return static_cast<int>(std::count_if(joints.begin(), joints.end(), yes) +
                          std::count_if(parameters.begin(), parameters.end(), yes));
}

ModelComparison compare(const Model& first, const Model& second, const ComparisonOptions& options) {
  require_one_arm(first, second);
  const Model before = without_frames_of_its_own(first, second);
  const Model after = without_frames_of_its_own(second, first);
  const Side a(before);
  const Side b(after);
  ModelComparison out;
  out.robot = before.name();
  out.significance = options.significance;
  out.before = facts_of(a);
  out.after = facts_of(b);
  out.structure = structure_differences(first, second);
  out.same_motion = same_motion(a.numbers, b.numbers);
  out.torque = torque_differences(a, b, out.same_motion);
  MatchedBase matched = matched_base(before, a.numbers, after, b.numbers, a.torque.column_sizes(),
                                     b.torque.column_sizes());
  out.only_before = std::move(matched.only_before);
  out.only_after = std::move(matched.only_after);
  const ClusterStatistics how{a.numbers.clusters, b.numbers.clusters, out.same_motion};
  for (const MatchedParameter& m : matched.parameters)
    out.parameters.push_back(parameter_difference(m, a, how, out.torque));
  out.joints = joint_differences(a, b, how);
  for (ModelDifference& d : out.joints) {
    if (!contains_expression(out.parameters, d.same_as)) d.same_as.clear();
  }
  correct_for_number(out);
  const auto by_p = [](const ModelDifference& x, const ModelDifference& y) {
    return x.p_value < y.p_value;
  };
  std::sort(out.joints.begin(), out.joints.end(), by_p);
  std::sort(out.parameters.begin(), out.parameters.end(),
            [&](const ModelDifference& x, const ModelDifference& y) {
              if (x.significant != y.significant) return x.significant;
              if (!x.significant) return by_p(x, y);
              return largest_share(x, out.torque) > largest_share(y, out.torque);
            });
  if (out.before.clusters == 0 && out.after.clusters == 0) {
    out.verdict = ComparisonVerdict::kCannotTell;
  } else {
    out.verdict = out.significant() > 0 ? ComparisonVerdict::kDiffer : ComparisonVerdict::kSame;
  }
  return out;
}

}  // namespace veridyn
