#include "veridyn/identification/rest_poses.hpp"

#include <algorithm>
#include <cmath>

#include "effects/plain_friction.hpp"
#include "identification/base_solution.hpp"
#include "identification/identification_numbers.hpp"
#include "identification/many_recordings.hpp"
#include "recordings/named_recordings.hpp"
#include "validation.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

Model with_effects_at_rest(const Model& file, bool approached) {
  ModelDescription d = file.description();
  d.effects.erase(std::remove_if(d.effects.begin(), d.effects.end(),
                                 [&](const EffectTerm& term) {
                                   return channel_effect(term.effect) != nullptr || !acts_at_rest(EffectFacts(file, term).traits(), approached);
                                 }),
                  d.effects.end());
  return Model(std::move(d));
}

VectorXd dry_friction(const Model& arm) {
  VectorXd out = VectorXd::Zero(arm.joints());
  for (const EffectTerm& term : arm.effects()) {
    if (!has_axis_effect(term.effect)) continue;
    const EffectFacts effect(arm, term);
    if (effect.traits().dry != DryFriction::kConstant || !effect.has_values()) continue;
    AxisSample moving;
    moving.ds = 1.0;
    out += std::abs(effect.force_at(moving)) * term.axis.coefficients.cwiseAbs();
  }
  return out;
}

namespace {

// The arm with the effects that act at rest; dry friction only if the approach is known.
Model resting_arm(const Model& file, bool approached) {
  ModelDescription d = with_effects_at_rest(file, approached).description();
  d.identified.reset();
  Model out = with_effect_of_all_joints(Model(std::move(d)), kPlainOffset);
  return approached ? with_effect_of_all_joints(out, kPlainCoulomb) : out;
}

// Drops effects that no pose determines, such as friction along an axis that was never approached.
Model without_idle_effects(const Model& arm, const std::vector<CompressedRecording>& poses) {
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  const VectorXd norms = weighted_total(joint_totals(poses), VectorXd::Ones(arm.joints()), parameter_names(parameters)).column_norms();
  std::vector<char> acts(arm.effects().size(), 0);
  for (size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].effect && norms[static_cast<Eigen::Index>(p)] > 0.0) acts[*parameters[p].effect] = 1;
  }
  ModelDescription d = arm.description();
  d.effects.clear();
  for (size_t e = 0; e < acts.size(); ++e) {
    const EffectTerm& term = arm.effects()[e];
    if (acts[e] != 0 || term.fixed) d.effects.push_back(term);
  }
  return Model(std::move(d));
}

// The arm with plausible bodies as a prior for the parameters that poses at rest do not determine.
Model with_ball_priors(const Model& arm) {
  ModelDescription d = arm.description();
  for (Frame& frame : d.frames) {
    if (!frame.body) continue;
    InertialParameters phi = InertialParameters::Zero();
    using identifying::kBallMass, identifying::kBallRadius, identifying::kSolidBall;
    phi[0] = kBallMass;
    phi[4] = phi[7] = phi[9] = kSolidBall * kBallMass * kBallRadius * kBallRadius;
    frame.body->phi = phi;
  }
  return Model(std::move(d));
}

bool has_prior(const Model& arm) {
  return std::any_of(arm.bodies().begin(), arm.bodies().end(), [&arm](FrameIndex frame) {
    return arm.frames()[frame.value].body->prior.has_value();
  });
}

// Reports the spread of the torques around the model: dry friction of an unknown approach, and errors of the
// model.
void report_friction_bands(const Model& arm, bool approached, Identification& id) {
  std::string words;
  for (int i = 0; i < arm.joints(); ++i) {
    const Coordinate& c = arm.coordinates()[i];
    std::vector<double> left;
    for (const RecordingError& r : id.train) {
      for (size_t k = 0; k < r.series.time.size(); ++k) left.push_back(std::abs(r.series.measured[i][k] - r.series.modelled[i][k]));
    }
    std::sort(left.begin(), left.end());
    const double band = left[static_cast<size_t>(identifying::kBand * static_cast<double>(left.size() - 1))];
    words += text(i > 0 ? ", " : "", c.name, " ", std::round(identifying::kBandSteps * band) / identifying::kBandSteps, " ",
                  c.prismatic ? "N" : "N m");
  }
  id.remarks.push_back(text(
      approached ? "What 95 % of the poses leave over, friction of the approach taken off, is within: "
                 : "Dry friction holds a resting joint anywhere within a band; 95 % of the poses are within, "
                   "on either side: ",
      words, "."));
}

}  // namespace

static_assert(kApproachSpeed >= kRestSpeed, "friction has its full level at the speed of an approach");

bool is_approached(const PreprocessingOptions& how, const std::vector<std::string>& poses) {
  return std::any_of(poses.begin(), poses.end(), [&how](const std::string& name) { return !find_in_memory(how.in_memory, name)->dq.isZero(0.0); });
}

Identification identify_at_rest(const Model& file, const std::vector<std::string>& train,
                                const std::vector<std::string>& test, const IdentificationOptions& options) {
  require(options.method != Method::kIv && options.method != Method::kDidim,
          "identify: found a method with instruments, which are motions, with poses at rest, expected another one.");
  const bool approached = is_approached(options.preprocessing, train);
  const Model resting = resting_arm(file, approached);
  const Model arm = without_idle_effects(resting, compress_all(resting, train, options.preprocessing, options.threads));
  IdentificationOptions how = options;
  if (!how.prior && !has_prior(arm)) how.prior = arm.inertial_values() ? arm : with_ball_priors(arm);
  Identification id = empty_identification(arm, options);
  id.factors = compress_all(arm, train, options.preprocessing, options.threads);
  for (const CompressedRecording& r : id.factors) id.rows += r.rows;
  const std::vector<std::string> names = parameter_names(standard_parameters(arm));
  std::vector<SquareRootInformation> joints = joint_totals(id.factors);
  const SquareRootInformation total = weighted_total(joints, range_weights(id.factors), names);
  const BaseParameters base = base_parameters(total, preferred_columns(standard_parameters(arm)), identifying::numbers.rest_rank);
  if (base.size() == 0) {
    id.reason = "the poses determine no parameter";
    return id;
  }
  fit_base(arm, id.factors, std::move(joints), base, how, id);
  if (!id.model) return id;
  id.rank_gap = base.rank_gap;
  validate(arm, test, how, id);
  report_friction_bands(arm, approached, id);
  store_training_error(id);
  id.remarks.insert(id.remarks.begin(),
                    text("Identified from ", static_cast<long>(id.rows / arm.joints()),
                         " poses at rest: they determine ", base.size(),
                         " parameters of gravity, offsets and forces of position. Inertia and viscous friction "
                         "are not in them: the model is for gravity, not for motion."));
  return id;
}

}  // namespace veridyn
