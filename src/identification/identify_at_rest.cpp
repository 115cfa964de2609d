#include "veridyn/identification/rest_poses.hpp"

#include <algorithm>
#include <cmath>

#include "effects/plain_friction.hpp"
#include "identification/base_solution.hpp"
#include "identification/identification_numbers.hpp"
#include "identification/many_recordings.hpp"
#include "validation.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

Model with_effects_at_rest(const Model& file, bool approached) {
  ModelDescription d = file.description();
  d.effects.erase(std::remove_if(d.effects.begin(), d.effects.end(),
                                 [&](const EffectTerm& term) {
                                   if (channel_effect(term.effect) != nullptr) return true;
                                   const EffectTraits t = EffectFacts(file, term).traits();
                                   const bool dry = t.dry == DryFriction::kConstant && approached;
                                   return t.memory || t.depends_on_time || t.uses_acceleration ||
                                          (t.uses_velocity && !dry);
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

// Rows of every joint: gravity of the bodies at rest, and effects in the state after a motion has stopped.
std::vector<JointRows> rows_of_poses(const Model& arm, const RestPoses& poses) {
  PreprocessingOptions as_they_are;
  as_they_are.cutoff = 0.0;
  Segment s;
  s.dt = 1.0;
  s.time = VectorXd::LinSpaced(poses.poses(), 0.0, static_cast<double>(poses.poses() - 1));
  s.q = poses.q;
  s.dq = kRestSpeed * poses.approach;
  s.ddq = MatrixXd::Zero(poses.poses(), arm.joints());
  s.tau = poses.tau;
  s.use.assign(static_cast<size_t>(poses.poses()), 1);
  s.core_end = poses.poses();
  const RegressorColumns all(arm, as_they_are);
  std::vector<JointRows> out = all.rows(s);
  s.dq.setZero();
  const std::vector<JointRows> still = all.rows(s);
  for (size_t i = 0; i < out.size(); ++i) {
    for (size_t p = 0; p < out[i].parameters.size(); ++p) {
      const StandardParameter& parameter = all.parameters()[out[i].parameters[p]];
      const auto column = static_cast<Eigen::Index>(p);
      if (!parameter.effect) out[i].A.col(column) = still[i].A.col(column);
    }
  }
  return out;
}

}  // namespace

CompressedRecording compress(const Model& arm, const RestPoses& poses) {
  const std::vector<JointRows> rows = rows_of_poses(arm, poses);
  const std::vector<std::string> names = parameter_names(standard_parameters(arm));
  const Eigen::Index blocks = std::min<Eigen::Index>(identifying::numbers.rest_blocks, poses.poses());
  CompressedRecording out;
  out.source = poses.source;
  out.facts.dt = 1.0;
  out.facts.samples = out.facts.rows_read = static_cast<long>(poses.poses());
  out.detached = true;
  out.blocks.resize(blocks);
  for (size_t i = 0; i < rows.size(); ++i) {
    std::vector<std::string> mine;
    for (const int p : rows[i].parameters) mine.push_back(names[p]);
    for (Eigen::Index b = 0; b < blocks; ++b) {
      const Eigen::Index from = b * poses.poses() / blocks;
      const Eigen::Index count = (b + 1) * poses.poses() / blocks - from;
      SquareRootInformation factor(mine);
      factor.absorb(rows[i].A.middleRows(from, count), rows[i].b.segment(from, count));
      out.blocks[b].push_back(std::move(factor));
    }
    const auto j = static_cast<Eigen::Index>(i);
    TorqueFacts facts;
    facts.minimum = poses.tau.col(j).minCoeff();
    facts.maximum = poses.tau.col(j).maxCoeff();
    facts.lowest = poses.q.col(j).minCoeff();
    facts.highest = poses.q.col(j).maxCoeff();
    out.joints.push_back(facts);
  }
  out.rows = static_cast<double>(poses.poses() * arm.joints());
  return out;
}

namespace {

// Drops effects that no pose determines, such as friction along an axis that was never approached.
Model without_idle_effects(const Model& arm, const std::vector<RestPoses>& poses) {
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  std::vector<char> acts(arm.effects().size(), 0);
  for (const RestPoses& some : poses) {
    for (const JointRows& joint : rows_of_poses(arm, some)) {
      for (size_t c = 0; c < joint.parameters.size(); ++c) {
        const std::optional<int> effect = parameters[joint.parameters[c]].effect;
        if (effect && joint.A.col(c).squaredNorm() > 0.0) acts[*effect] = 1;
      }
    }
  }
  ModelDescription d = arm.description();
  d.effects.clear();
  for (size_t e = 0; e < acts.size(); ++e) {
    const EffectTerm& term = arm.effects()[e];
    if (acts[e] != 0 || term.fixed) d.effects.push_back(term);
  }
  return Model(std::move(d));
}

// Torques (poses x n) of the arm with these parameters.
MatrixXd modelled_torques(const Model& arm, const RestPoses& poses, const VectorXd& values) {
  MatrixXd out(poses.poses(), arm.joints());
  const std::vector<JointRows> rows = rows_of_poses(arm, poses);
  for (size_t i = 0; i < rows.size(); ++i) {
    VectorXd mine(rows[i].A.cols());
    for (Eigen::Index p = 0; p < mine.size(); ++p)
      mine[p] = values[rows[i].parameters[p]];
    const auto j = static_cast<Eigen::Index>(i);
    out.col(j) = poses.tau.col(j) - rows[i].b + rows[i].A * mine;  // known values are part of b
  }
  return out;
}

std::vector<std::vector<double>> columns(const MatrixXd& m) {
  std::vector<std::vector<double>> out;
  for (Eigen::Index j = 0; j < m.cols(); ++j) out.emplace_back(m.col(j).data(), m.col(j).data() + m.rows());
  return out;
}

// No joint moves: there is no error of moving rows.
PredictionError rest_error(const ErrorSums& sums) {
  PredictionError out = sums.error();
  out.moving_relative.resize(0);
  return out;
}

RecordingError error_on(const Model& arm, const RestPoses& poses, const VectorXd& values, ErrorSums& all,
                        MatrixXd& residuals) {
  const MatrixXd torque = modelled_torques(arm, poses, values);
  ErrorSums sums(arm.joints());
  for (Eigen::Index k = 0; k < poses.poses(); ++k) {
    for (int i = 0; i < arm.joints(); ++i) sums.add(i, poses.tau(k, i), torque(k, i), MovingSample::kNo);
  }
  all.add(sums);
  RecordingError out;
  out.source = poses.source;
  out.error = rest_error(sums);
  out.rows = static_cast<long>(poses.poses());
  for (Eigen::Index k = 0; k < poses.poses(); ++k) out.series.time.push_back(static_cast<double>(k));
  out.series.q = columns(poses.q);
  out.series.dq = out.series.ddq = columns(MatrixXd::Zero(poses.poses(), arm.joints()));
  out.series.measured = columns(poses.tau);
  out.series.modelled = columns(torque);
  const Eigen::Index before = residuals.rows();
  residuals.conservativeResize(before + poses.poses(), arm.joints());
  residuals.bottomRows(poses.poses()) = poses.tau - torque;
  return out;
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
  return std::any_of(arm.bodies().begin(), arm.bodies().end(), [&arm](int frame) {
    return arm.frames()[frame].body->prior.has_value();
  });
}

double quantile(VectorXd values, double share) {
  std::sort(values.data(), values.data() + values.size());
  return values[static_cast<Eigen::Index>(share * static_cast<double>(values.size() - 1))];
}

// Reports the spread of the torques around the model: dry friction of an unknown approach, and errors of the
// model.
void report_friction_bands(const Model& arm, const MatrixXd& residuals, bool approached, Identification& id) {
  std::string words;
  for (int i = 0; i < arm.joints(); ++i) {
    const Coordinate& c = arm.coordinates()[i];
    const double band = quantile(residuals.col(i).cwiseAbs(), identifying::kBand);
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

Identification identify_at_rest(const Model& file, const std::vector<RestPoses>& train,
                                const std::vector<RestPoses>& test, const IdentificationOptions& options) {
  require(!train.empty(), "identify_at_rest: there is no recording to train on.");
  require(options.method != Method::kIv && options.method != Method::kDidim,
          "identify_at_rest: found a method with instruments, which are motions, expected another one.");
  for (const auto* list : {&train, &test}) {
    for (const RestPoses& poses : *list) {
      require(poses.q.cols() == file.joints() && poses.tau.cols() == file.joints() &&
                  poses.approach.cols() == file.joints() && poses.tau.rows() == poses.poses() &&
                  poses.approach.rows() == poses.poses(),
              poses.source, ": found poses of ", poses.q.cols(), " joints, expected the ", file.joints(),
              " of robot '", file.name(), "'.");
      require(poses.poses() > 0 && poses.q.allFinite() && poses.tau.allFinite() && poses.approach.allFinite(), poses.source,
              ": found ", poses.poses() > 0 ? "a pose with a number that is not finite" : "no pose", ", expected poses at rest.");
    }
  }
  const bool approached = std::any_of(train.begin(), train.end(), [](const RestPoses& p) {
    return (p.approach.array() != 0.0).any();
  });
  const Model arm = without_idle_effects(resting_arm(file, approached), train);
  IdentificationOptions how = options;
  if (!how.prior && !has_prior(arm)) how.prior = arm.inertial_values() ? arm : with_ball_priors(arm);
  Identification id = empty_identification(arm, options);
  std::vector<CompressedRecording> factors;
  for (const RestPoses& poses : train) factors.push_back(compress(arm, poses));
  for (const CompressedRecording& r : factors) id.rows += r.rows;
  const std::vector<std::string> names = parameter_names(standard_parameters(arm));
  std::vector<SquareRootInformation> joints = joint_totals(factors);
  const SquareRootInformation total = weighted_total(joints, range_weights(factors), names);
  const BaseParameters base = base_parameters(total, preferred_columns(standard_parameters(arm)), identifying::numbers.rest_rank);
  if (base.size() == 0) {
    id.reason = "the poses determine no parameter";
    return id;
  }
  fit_base(arm, factors, std::move(joints), base, how, id);
  if (!id.model) return id;
  id.rank_gap = base.rank_gap;
  ErrorSums of_train(arm.joints());
  ErrorSums of_test(arm.joints());
  MatrixXd residuals(0, arm.joints());
  for (const RestPoses& poses : train)
    id.train.push_back(error_on(arm, poses, id.parameters, of_train, residuals));
  report_friction_bands(arm, residuals, approached, id);
  for (const RestPoses& poses : test)
    id.test.push_back(error_on(arm, poses, id.parameters, of_test, residuals));
  id.train_error = rest_error(of_train);
  if (!test.empty()) id.test_error = rest_error(of_test);
  id.factors = std::move(factors);
  store_training_error(id);
  id.remarks.insert(id.remarks.begin(),
                    text("Identified from ", static_cast<long>(id.rows / arm.joints()),
                         " poses at rest: they determine ", base.size(),
                         " parameters of gravity, offsets and forces of position. Inertia and viscous friction "
                         "are not in them: the model is for gravity, not for motion."));
  return id;
}

}  // namespace veridyn
