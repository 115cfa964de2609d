#include "veridyn/identification/friction_curve.hpp"

#include <algorithm>
#include <cmath>

#include "identification/identification_numbers.hpp"
#include "regressor/effect_along.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {

using identifying::kNormal95, identifying::kRun, identifying::kRunSeconds, identifying::kSpeeds;

namespace {

// Friction of one joint in steady sliding. `columns`, unless null, is set to its derivatives with respect to
// the parameters.
double friction_at(const std::vector<EffectFacts>& effects, int joint, double speed, double q, double load,
                   VectorXd* columns) {
  double torque = 0.0;
  Eigen::Index at = 0;
  for (const EffectFacts& effect : effects) {
    const double c = effect.term().axis.coefficients[joint];
    std::vector<AxisSample> slide(c != 0.0 ? kRun : 0);
    for (int k = 0; k < static_cast<int>(slide.size()); ++k) {
      AxisSample& sample = slide[k];
      sample.time = kRunSeconds * k / kRun;
      sample.ds = c * speed;
      sample.s = c * q + effect.term().axis.offset + sample.ds * kRunSeconds * (k + 1 - kRun) / kRun;  // ends at position q
      sample.load = load;
    }
    const MatrixXd rows = ColumnsInPieces(effect).next(slide);
    for (int p = 0; p < effect.parameter_count(); ++p, ++at) {
      const auto place = static_cast<std::size_t>(p);
      const double column = c != 0.0 ? c * rows(kRun - 1, p) : 0.0;
      torque += column * effect.values()[place];
      if (columns != nullptr) (*columns)[at] = column;
    }
  }
  return torque;
}

// Factor F of the parameters' covariance F F', one row for each parameter: the scatter of the jackknife if
// the parameter is identifiable by itself, else its standard deviation in a column of its own.
MatrixXd scatter_of(const Identification& id, const std::vector<std::string>& names) {
  const auto& identified = id.model->description().identified;
  const auto count = static_cast<Eigen::Index>(names.size());
  Eigen::Index clusters = 0;
  if (identified && identified->has_scatter()) clusters = identified->parameters.front().scatter.size();
  MatrixXd F = MatrixXd::Zero(count, clusters + count);
  const std::vector<StandardParameter> all = standard_parameters(*id.model);
  for (Eigen::Index j = 0; j < count; ++j) {
    const std::string& name = names[j];
    bool alone = false;
    for (std::size_t b = 0; clusters > 0 && b < identified->parameters.size() && !alone; ++b) {
      const IdentifiedParameter& p = identified->parameters[b];
      alone = p.name == name && p.combination.size() == 1 && p.scatter.size() == clusters;
      if (alone) F.row(j).head(clusters) = p.scatter.transpose();
    }
    for (std::size_t k = 0; k < all.size() && !alone; ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      if (all[k].name == name && at < id.parameter_deviations.size() &&
          std::isfinite(id.parameter_deviations[at]))
        F(j, clusters + j) = id.parameter_deviations[at];
    }
  }
  return F;
}

struct JointUse {
  double speed = 0.0, q = 0.0, load = 0.0;
};

JointUse use_of(const Identification& id, std::size_t joint) {
  JointUse out;
  double rows = 0.0;
  for (const RecordingError& r : id.train) {
    const PredictionSeries& s = r.series;
    for (std::size_t k = 0; joint < s.dq.size() && k < s.time.size(); ++k) {
      out.speed = std::max(out.speed, std::abs(s.dq[joint][k]));
      out.q += s.q[joint][k];
      out.load += s.modelled[joint][k] * s.modelled[joint][k];
      rows += 1.0;
    }
  }
  if (rows > 0.0) {
    out.q /= rows;
    out.load = std::sqrt(out.load / rows);
  }
  return out;
}

}  // namespace

double FrictionCurve::at(double speed) const {
  const double* first = velocity.data();
  const double* end = first + velocity.size();
  const Eigen::Index k = std::lower_bound(first, end, speed) - first;
  if (k == 0) return torque[0];
  if (k == velocity.size()) return torque[k - 1];
  const double share = (speed - velocity[k - 1]) / (velocity[k] - velocity[k - 1]);
  return torque[k - 1] + share * (torque[k] - torque[k - 1]);
}

std::vector<FrictionCurve> friction_curves(const Identification& id) {
  const Model& arm = *id.model;
  std::vector<EffectFacts> effects;
  std::vector<std::string> names;
  for (const EffectTerm& term : arm.effects()) {
    if (!term.frame.empty() || !has_axis_effect(term.effect)) continue;
    EffectFacts effect(arm, term);
    if (effect.traits().role != EffectRole::kFriction) continue;
    for (std::string& name : effect.parameter_names()) names.push_back(std::move(name));
    effects.push_back(std::move(effect));
  }
  std::vector<FrictionCurve> out;
  if (effects.empty()) return out;
  const MatrixXd F = scatter_of(id, names);
  for (int joint = 0; joint < arm.joints(); ++joint) {
    const JointUse use = use_of(id, static_cast<std::size_t>(joint));
    if (use.speed <= kRestSpeed) continue;
    FrictionCurve curve{{joint}, VectorXd(2 * kSpeeds), VectorXd(2 * kSpeeds), VectorXd(2 * kSpeeds)};
    VectorXd columns(F.rows());
    for (int k = 0; k < 2 * kSpeeds; ++k) {
      const int rank = k < kSpeeds ? k - kSpeeds : k - kSpeeds + 1;  // skips a speed of zero
      const double share = static_cast<double>(rank) / kSpeeds;
      curve.velocity[k] = use.speed * share * std::abs(share);  // speeds are denser near zero
      curve.torque[k] = friction_at(effects, joint, curve.velocity[k], use.q, use.load, &columns);
      curve.half_width[k] = kNormal95 * (F.transpose() * columns).norm();
    }
    out.push_back(std::move(curve));
  }
  return out;
}

}  // namespace veridyn
