#include "diagnosis/stages/newly_visible.hpp"

#include <algorithm>
#include <utility>

#include "diagnosis/evidence/numerics.hpp"
#include "diagnosis/shapes/candidate_data.hpp"
#include "math/student_t.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/identification/base_parameters.hpp"

namespace veridyn {
namespace {

constexpr const char* kAddition = "addition to ";

Model with_gravity(const Model& arm, const Eigen::Vector3d& gravity) {
  ModelDescription d = arm.description();
  d.gravity = gravity;
  return Model(std::move(d));
}

Model without_effects(const Model& arm) {
  ModelDescription d = arm.description();
  d.effects.clear();
  return Model(std::move(d));
}

// A body of nothing on every one that the arm has.
Model with_additions(const Model& arm, const std::vector<int>& bodies) {
  ModelDescription d = arm.description();
  for (const int at : bodies) {
    Frame more;
    more.name = kAddition + d.frames[at].name;
    more.parent = FrameIndex{at};
    more.variable.coefficients = VectorXd::Zero(arm.joints());
    more.body = Body{};
    more.body->phi = InertialParameters::Zero();
    d.frames.push_back(std::move(more));
  }
  return Model(std::move(d));
}

// The correction evaluated again together with these additions.
AugmentedModel asked_together(const DiagnosisState& x, const Identification& corrected,
                              const Hypothesis& h, const std::vector<std::string>& names) {
  const Model& arm = *corrected.model;
  CandidateList list = x.list();
  list.wanted = {effect_of(h.cause)};
  AugmentedModel out = augmented_model(with_fixed_parameters(arm), corrected.factors, list);
  out.model = with_additions(out.model, arm.bodies());
  auto& all = out.hypotheses;
  all.erase(std::remove_if(all.begin(), all.end(),
                           [&h](const Hypothesis& other) { return !same_candidate(other, h); }),
            all.end());
  const auto bodies = static_cast<int>(arm.bodies().size());
  Hypothesis unknown;
  unknown.cause = AddedLoad{FrameIndex{arm.bodies().front()}};
  unknown.part = BodyIndex{bodies};
  const std::vector<StandardParameter> additions = standard_parameters(out.model);
  for (const StandardParameter& p : standard_parameters(arm)) {
    if (std::find(names.begin(), names.end(), p.name) == names.end()) continue;
    for (const StandardParameter& a : additions) {
      if (p.body && a.body == *p.body + bodies && a.component == p.component)
        unknown.columns.push_back(a.name);
    }
  }
  all.push_back(unknown);
  return out;
}

// One step of both. False if the training error does not fall.
bool step_together(const DiagnosisState& x, const Hypothesis& h,
                   const std::vector<std::string>& names, CorrectedChannel& channel) {
  const Model& arm = *channel.corrected.model;
  const CandidateData q = prepare(channel.corrected, asked_together(x, channel.corrected, h, names), true,
                            x.train, {}, x.options.identification);
  const NormalBlocks data(q.train, q.columns);
  const Selection fit = refit(data, q.base, q.augmented.hypotheses, x.options);
  const Hypothesis& own = q.augmented.hypotheses.front();
  const double t = student_t_quantile(numerics::kOutside, fit.degrees_of_freedom);
  std::vector<double> values;
  ModelDescription d = arm.description();
  const std::vector<StandardParameter> all = standard_parameters(q.augmented.model);
  for (size_t k = 0; k < fit.columns.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    if (k < own.columns.size()) {
      values.push_back(fit.values[at]);
      channel.half_widths[at] = t * fit.standard_deviations[at];
      continue;
    }
    const std::string& name = data.names()[fit.columns[k]];
    const auto a = std::find_if(all.begin(), all.end(),
                                [&name](const StandardParameter& p) { return p.name == name; });
    const size_t body = static_cast<size_t>(*a->body) - arm.bodies().size();
    Frame& frame = d.frames[arm.bodies()[body]];
    (*frame.body->phi)[a->component] += fit.values[at];
  }
  const EffectTerm& term = term_of(q.augmented.model, own);
  const Identification candidate = x.fit(with_channel_error(Model(std::move(d)), term, values));
  if (!candidate.model ||
      log_training_error(candidate) >= log_training_error(channel.corrected))
    return false;
  channel.corrected = candidate;
  channel.values = together(h, channel.values, values);
  return true;
}

}  // namespace

std::vector<std::string> newly_visible(const Model& tilted, const Eigen::Vector3d& gravity) {
  const Model arm = without_effects(tilted);
  const BaseParameters before = base_parameters(with_gravity(arm, gravity));
  const BaseParameters now = base_parameters(arm);
  if (now.size() == before.size()) return {};
  // Changes of the base parameters that leave the earlier ones constant: phi_j by one, compensated
  // by the earlier independent ones.
  MatrixXd unknown = now.K;
  for (int r = 0; r < before.size(); ++r) {
    const VectorXd makes_up = now.K.col(before.independent[r]);
    unknown -= makes_up * before.K.row(r);
  }
  const double least = numerics::kSameAxis * unknown.norm();
  const std::vector<std::string> names = parameter_names(standard_parameters(arm));
  std::vector<std::string> out;
  for (int k = 0; k < now.size(); ++k) {
    if (unknown.row(k).norm() > least)
      out.push_back(names[now.independent[k]]);
  }
  return out;
}

void estimate_newly_visible(const DiagnosisState& x, const Hypothesis& h,
                            CorrectedChannel& channel) {
  const Eigen::Vector3d before = x.start.model->gravity();
  if (!x.d.changes || channel.corrected.model->gravity() == before) return;
  const std::vector<std::string> names = newly_visible(*channel.corrected.model, before);
  if (names.empty()) return;
  for (int k = 0; k < numerics::kStepsTogether && step_together(x, h, names, channel); ++k) {
  }
}

}  // namespace veridyn
