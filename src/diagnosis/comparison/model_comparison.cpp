#include "veridyn/diagnosis/model_comparison.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/comparison/comparison_numbers.hpp"
#include "diagnosis/comparison/comparison_words.hpp"
#include "diagnosis/comparison/estimates.hpp"
#include "diagnosis/comparison/model_structure.hpp"
#include "diagnosis/comparison/standard_torque.hpp"
#include "math/numbers.hpp"
#include "math/student_t.hpp"

namespace veridyn {
namespace {

// One of the two models with derived quantities.
struct Side {
  Side(const Model& model, const Model& other) : arm(model), to_other(model, other), known(model, to_other.own), torque(model) {}

  // Torques of a joint over the standard motion: of all parameters, of the bodies and of the effects (rows x 3).
  MatrixXd torques(int joint) const {
    MatrixXd values(torque.parameters.size(), 3);
    for (size_t j = 0; j < torque.parameters.size(); ++j) {
      const StandardParameter& p = torque.parameters[j];
      values.row(static_cast<Eigen::Index>(j)) << p.value, p.effect ? 0.0 : p.value, p.effect ? p.value : 0.0;
    }
    return torque.torque(joint, values);
  }

  // Torques of a joint that belong to the scatter of the base parameters (rows x clusters): the column of a base parameter
  // is that of its leading parameter.
  MatrixXd scattered_torques(int joint) const {
    MatrixXd values = MatrixXd::Zero(torque.parameters.size(), known.scatter.cols());
    values(known.leading, Eigen::all) = known.scatter;
    return torque.torque(joint, values);
  }

  const Model& arm;
  Correspondence to_other;
  Estimates known;
  StandardTorque torque;
};

ComparedModel compared_model_of(const Side& side) {
  ComparedModel out;
  out.name = side.arm.name();
  out.clusters = side.known.clusters;
  out.note = side.known.note;
  if (const auto& identified = side.arm.description().identified) {
    out.recordings = identified->recordings;
    out.training_error = identified->error;
  }
  return out;
}

// Contributions of clusters, independent of those of another group: each model is a group; both are one where their motion
// is the same, since errors of the model at one phase occur in both.
template <typename Contributions>
struct Group {
  Contributions scatter;
  int clusters;
};

template <typename Contributions>
std::vector<Group<Contributions>> groups(const Side& a, const Contributions& of_a, const Side& b, const Contributions& of_b) {
  if (same_motion(a.known, b.known)) return {{of_b - of_a, a.known.clusters}};
  std::vector<Group<Contributions>> out;
  if (a.known.clusters > 0) out.push_back({of_a, a.known.clusters});
  if (b.known.clusters > 0) out.push_back({of_b, b.known.clusters});
  return out;
}

// Degrees of freedom of a sum of squares that a few clusters may dominate: Satterthwaite's (sum v)^2 / sum
// v^2 for normal contributions of variances v_c, with d_c^4 in place of 3 v_c^2, corrected for the value that
// equal clusters give by chance.
double degrees_of_freedom(const VectorXd& scatter, int clusters) {
  const double most = std::max(1, clusters - 1);
  if (scatter.size() != clusters) return most;  // no longer one column per cluster
  const double fourth = scatter.array().pow(4).sum();
  if (!(fourth > 0.0)) return most;
  const double spread = comparing::kKurtosis * std::pow(scatter.squaredNorm(), 2) / fourth - 2.0;
  return std::clamp(spread, 0.5 * most, most);
}

// The values of one quantity and the statistics of their difference: Welch's test over groups of clusters.
ModelDifference difference_of(const Side& a, const Estimate& before, const Side& b, const Estimate& after) {
  ModelDifference d;
  d.before = before.value;
  d.after = after.value;
  d.difference = d.after - d.before;
  d.deviation = kNaN;
  double variance = 0.0, parts = 0.0;
  for (const auto& [scatter, clusters] : groups(a, before.scatter, b, after.scatter)) {
    const double freedom = degrees_of_freedom(scatter, clusters), v = scatter.squaredNorm();
    variance += v;
    parts += v * v / freedom;
    d.degrees_of_freedom = std::max(d.degrees_of_freedom, freedom);
  }
  if (d.degrees_of_freedom == 0.0) return d;  // no statistics
  if (parts > 0.0) d.degrees_of_freedom = variance * variance / parts;
  const double rounding = comparing::kSameToRounding * std::max(std::abs(d.before), std::abs(d.after));
  d.deviation = std::sqrt(variance + rounding * rounding);
  if (!(d.deviation > 0.0)) return d;
  d.t = d.difference / d.deviation;
  d.p_value = student_t_two_sided(d.t, d.degrees_of_freedom);
  const double reach = d.deviation * student_t_quantile(comparing::kOutside, d.degrees_of_freedom);
  d.low = d.difference - reach;
  d.high = d.difference + reach;
  return d;
}

// The difference of every joint's torque over the standard motion, with its parts from bodies and effects.
std::vector<TorqueDifference> torque_differences(const Side& a, const Side& b) {
  std::vector<TorqueDifference> out;
  for (int i = 0; i < a.arm.joints(); ++i) {
    const MatrixXd before = a.torques(i), after = b.torques(i);
    const VectorXd parts = rms(after - before);
    const double size = rms(before)[0];
    const auto chance = groups(a, a.scattered_torques(i), b, b.scattered_torques(i));
    double variance = chance.empty() ? kNaN : 0.0;
    for (const auto& group : chance) variance += group.scatter.squaredNorm() / static_cast<double>(group.scatter.rows());
    const Coordinate& c = a.arm.coordinates()[i];
    out.push_back({c.name, effort_unit(c), size, rms(after)[0], parts[0], size > 0.0 ? parts[0] / size : kNaN, std::sqrt(variance), parts[1], parts[2]});
  }
  return out;
}

// The joint of which a torque is the largest share, and that share.
std::pair<int, double> largest_share(const VectorRef& torque, const std::vector<TorqueDifference>& joints) {
  std::pair<int, double> out(0, -1.0);
  for (size_t i = 0; i < joints.size(); ++i) {
    const double share = torque[static_cast<Eigen::Index>(i)] / std::max(joints[i].before, 1e-300);
    if (share > out.second) out = {static_cast<int>(i), share};
  }
  return out;
}

// Every base parameter of `before` that the other model determines as well; expressions of the others.
void compare_parameters(const Side& a, const Side& b, ModelComparison& out) {
  // Sizes of the parameters' columns; a column that the standard motion does not excite counts by itself.
  const auto sizes = [](const Side& side) {
    const VectorXd size = side.torque.rms.colwise().norm();
    return VectorXd((size.array() > 0.0).select(size, 1.0));
  };
  const VectorXd sizes_a = sizes(a), sizes_b = sizes(b);
  const auto determined = [](const Side& side, const VectorXd& w, const Side& other, const VectorXd& other_sizes) {
    return side.to_other.foreign.cwiseProduct(w).isZero(0.0) && other.known.determines(side.to_other.M * w, other_sizes);
  };
  for (int r = 0; r < a.known.identified; ++r) {
    const VectorXd w = a.known.K.row(r).transpose();
    if (!determined(a, w, b, sizes_b)) {
      out.only_before.push_back(a.known.expressions[r]);
      continue;
    }
    const VectorXd w_b = a.to_other.M * w, w_a = b.to_other.M * w_b;  // with the known bodies that only one model has
    ModelDifference d = difference_of(a, a.known.of(w_a), b, b.known.of(w_b));
    const int leading = a.known.leading[r];
    const StandardParameter& p = a.torque.parameters[leading];
    d.name = p.name;
    d.expression = a.known.expressions[r];
    d.unit = p.unit;
    d.torque = std::abs(d.difference) * a.torque.rms.col(leading);
    d.joint = {largest_share(a.torque.rms.col(leading), out.torque).first};
    if (p.effect) {
      const EffectTerm& term = a.arm.effects()[*p.effect];
      d.effect = term.effect;
      d.joint = main_coordinate(term.axis);
    }
    d.coordinate = a.arm.coordinates()[d.joint.value].name;
    d.sentence = parameter_sentence(a.arm, a.torque, leading, d);
    out.parameters.push_back(std::move(d));
  }
  for (int r = 0; r < b.known.identified; ++r) {
    if (!determined(b, b.known.K.row(r).transpose(), a, sizes_a)) out.only_after.push_back(b.known.expressions[r]);
  }
}

// The base parameter to which a quantity is proportional; empty if there are several, or if it is not compared.
std::string proportional_parameter(const Estimates& known, const VectorXd& u, const std::vector<ModelDifference>& compared) {
  std::string found;
  for (int r = 0; r < known.identified; ++r) {
    if (u[known.leading[r]] == 0.0) continue;
    if (!found.empty()) return "";
    found = known.expressions[r];
  }
  return std::any_of(compared.begin(), compared.end(), [&](const ModelDifference& d) { return d.expression == found; }) ? found : "";
}

// Adds to out.joints each quantity of each joint that both models have.
void compare_joints(const Side& a, const Side& b, ModelComparison& out) {
  for (int i = 0; i < a.arm.joints(); ++i) {
    for (const JointQuantity& which : kJointQuantities) {
      const VectorXd u_a = a.torque.quantities[i].col(&which - kJointQuantities);
      const VectorXd u_b = b.torque.quantities[i].col(&which - kJointQuantities);
      const bool none_a = u_a.isZero(0.0), none_b = u_b.isZero(0.0), friction = &which == kJointQuantities;
      // A model without terms of friction does not say that there is none; `structure` names it.
      if (friction ? none_a || none_b : none_a && none_b) continue;
      const Coordinate& c = a.arm.coordinates()[i];
      ModelDifference d = difference_of(a, a.known.of(u_a), b, b.known.of(u_b));
      d.quantity = which.quantity;
      d.unit = d.quantity != ComparedQuantity::kInertia ? effort_unit(c) : c.prismatic ? "kg" : "kg m^2";
      d.joint = {i};
      d.coordinate = c.name;
      d.same_as = proportional_parameter(a.known, u_a, out.parameters);
      d.sentence = joint_sentence(a.arm, which, d);
      out.joints.push_back(std::move(d));
    }
  }
}

// Holm's correction over all compared numbers: the k-th smallest p-value of m is multiplied by m - k + 1, and never below
// the previous one. A joint's number with same_as is corrected together with its parameter.
void correct_for_number(ModelComparison& c) {
  std::vector<ModelDifference*> all;
  for (ModelDifference& d : c.joints) {
    if (d.same_as.empty()) all.push_back(&d);
  }
  for (ModelDifference& d : c.parameters) all.push_back(&d);
  std::sort(all.begin(), all.end(), [](const ModelDifference* x, const ModelDifference* y) { return x->p_value < y->p_value; });
  double least = 0.0;
  for (size_t k = 0; k < all.size(); ++k) {
    least = std::max(least, std::min(1.0, all[k]->p_value * static_cast<double>(all.size() - k)));
    all[k]->p_corrected = least;
    all[k]->significant = least < c.significance;
  }
  for (ModelDifference& joint : c.joints) {
    for (const ModelDifference& d : c.parameters) {
      if (joint.same_as.empty() || joint.same_as != d.expression) continue;
      joint.p_corrected = d.p_corrected;
      joint.significant = d.significant;
    }
  }
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

ModelComparison compare(const Model& before, const Model& after, const ComparisonOptions& options) {
  ModelComparison out;
  out.structure = structure_differences(before, after);
  const Side a(before, after), b(after, before);
  out.robot = before.name();
  out.significance = options.significance;
  out.before = compared_model_of(a);
  out.after = compared_model_of(b);
  out.same_motion = same_motion(a.known, b.known);
  out.torque = torque_differences(a, b);
  compare_parameters(a, b, out);
  compare_joints(a, b, out);
  correct_for_number(out);
  const auto by_p = [](const ModelDifference& x, const ModelDifference& y) { return x.p_value < y.p_value; };
  std::sort(out.joints.begin(), out.joints.end(), by_p);
  std::sort(out.parameters.begin(), out.parameters.end(), [&](const ModelDifference& x, const ModelDifference& y) {
    if (x.significant != y.significant) return x.significant;
    if (!x.significant) return by_p(x, y);
    return largest_share(x.torque, out.torque).second > largest_share(y.torque, out.torque).second;
  });
  if (out.before.clusters == 0 && out.after.clusters == 0)
    out.verdict = ComparisonVerdict::kCannotTell;
  else
    out.verdict = out.significant() > 0 ? ComparisonVerdict::kDiffer : ComparisonVerdict::kSame;
  return out;
}

}  // namespace veridyn
