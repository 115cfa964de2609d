#include "diagnosis/watch/hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "veridyn/math/require.hpp"
#include "veridyn/effects/effect_facts.hpp"

namespace veridyn::watching {
namespace {

std::string unit_of(const Model& arm, const Candidate& c) {
  if (is_load(c)) return "kg";
  const EffectParameter p = find_effect(effect_of(c.cause)).parameters().front();
  const bool slides = arm.coordinates()[c.joint ? c.joint->value : 0].prismatic;
  return slides ? p.unit_prismatic : p.unit_revolute;
}

std::vector<FrameIndex> load_frames(const Model& arm, const std::vector<std::string>& links) {
  std::vector<FrameIndex> out;
  for (const std::string& link : links) {
    const FrameIndex frame = find_frame(arm, link, "watch: robot '" + arm.name() + "'");
    if (std::find(out.begin(), out.end(), frame) == out.end()) out.push_back(frame);
  }
  if (!links.empty()) return out;
  std::vector<bool> last(arm.frames().size(), true), moves(arm.frames().size(), false);
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    if (const auto parent = arm.frames()[k].parent) last[parent->value] = false;
    for (int i = 0; i < arm.joints(); ++i) moves[k] = moves[k] || arm.moves({k}, {i});
  }
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    if (moves[k] && (last[k] || arm.frames()[k].body)) out.push_back({k});
  }
  return out;
}

// The arm with an additional body on each of the frames.
Model with_bodies(const Model& arm, const std::vector<FrameIndex>& frames) {
  ModelDescription d = arm.description();
  d.effects.clear();
  for (const FrameIndex k : frames) {
    std::optional<Body>& body = d.frames[k.value].body;
    if (!body) body.emplace();
  }
  return Model(std::move(d));
}

VectorXd values_of(const Model& arm) {
  const auto phi = arm.inertial_values();
  require(phi.has_value(), "watch: robot '", arm.name(),
          "' has bodies without values, expected a MODEL that identify or diagnose wrote.");
  return *phi;
}

}  // namespace

Hypotheses::Hypotheses(const Model& arm, const std::vector<std::string>& links, double seconds, const WatchNumbers& numbers)
    : numbers_(numbers),
      seconds_(seconds),
      arm_(arm),
      loaded_(with_bodies(arm, load_frames(arm, links))),
      bodies_(arm),
      loads_(loaded_),
      phi_(values_of(arm)) {
  for (const EffectTerm& term : arm.effects()) {
    if (!has_axis_effect(term.effect)) continue;
    EffectFacts effect(arm, term);
    require(effect.has_values() || effect.parameter_count() == 0, "watch: robot '", arm.name(), "': ",
            effect.parameter_name(0), " has no value, expected a MODEL that identify or diagnose wrote.");
    if (effect.traits().dry != DryFriction::kNone) dry_.push_back({effects_.size()});
    effects_.emplace_back(std::move(effect));
  }
  for (const Candidate& c : sudden_candidates(arm, load_frames(arm, links))) {
    all_.push_back({c, unit_of(arm, c)});
    if (is_load(c)) {
      const auto at = std::find(loaded_.bodies().begin(), loaded_.bodies().end(), *frame_of(c.cause));
      body_of_load_.push_back(static_cast<int>(at - loaded_.bodies().begin()));
    } else if (is_channel(c)) {
      channel_.push_back(channel_effect(effect_of(c.cause)));
    } else {
      EffectTerm term;
      term.effect = effect_of(c.cause);
      term.axis = c.axis;
      axis_.emplace_back(EffectFacts(arm, term));
    }
  }
  const size_t loads = body_of_load_.size();
  const size_t first = all_.size() - loads;
  for (size_t l = 0; l < loads; ++l) {
    for (int axis = 0; axis < 3; ++axis) {
      all_[first + l].companions.push_back(static_cast<int>(all_.size()));
      Hypothesis moment = all_[first + l];
      moment.companions.clear();
      moment.companion = true;
      moment.unit = "kg m";
      all_.push_back(moment);
    }
  }
}

void Hypotheses::restart() {
  rows_ = 0;
  follows_ = false;
  for (ColumnsInPieces& effect : effects_) effect.reset();
  for (ColumnsInPieces& effect : axis_) effect.reset();
}

std::optional<Step> Hypotheses::add(const SmoothedRow& row, double dt, double spacing) {
  const Eigen::Index count = std::max(1L, std::lround(seconds_ / dt));
  if (q_.rows() != count) {
    time_.resize(count);
    for (MatrixXd* m : {&q_, &dq_, &ddq_, &tau_}) m->resize(count, arm_.joints());
  }
  time_[rows_] = row.time;
  q_.row(rows_) = row.q.transpose();
  dq_.row(rows_) = row.dq.transpose();
  ddq_.row(rows_) = row.ddq.transpose();
  tau_.row(rows_) = row.tau.transpose();
  if (++rows_ < count) return {};
  rows_ = 0;
  return make_step(dt, spacing);
}

Step Hypotheses::make_step(double dt, double spacing) {
  const Eigen::Index n = arm_.joints();
  MatrixXd torque, weight;
  bodies_.torques(q_, dq_, ddq_, phi_, torque);
  const MatrixXd still = MatrixXd::Zero(q_.rows(), n);
  bodies_.torques(q_, still, still, phi_, weight);
  Step out;
  out.time = time_.mean();
  out.torque = tau_.colwise().mean().transpose();
  out.position = q_.bottomRows(1).transpose();
  out.parts = MatrixXd::Zero(n, 3);
  out.parts.col(0) = weight.cwiseAbs().colwise().mean().transpose();
  out.parts.col(1) = (torque - weight).cwiseAbs().colwise().mean().transpose();
  add_effects(MatrixXd(torque), spacing, torque, out);
  out.residual = (tau_ - torque).colwise().mean().transpose();
  add_columns(torque, dt, out);
  out.follows = std::exchange(follows_, true);
  return out;
}

void Hypotheses::add_effects(const MatrixXd& rigid, double spacing, MatrixXd& torque, Step& out) {
  const auto rows = static_cast<double>(q_.rows());
  VectorXd undetermined = VectorXd::Zero(arm_.joints());
  std::vector<Dry>::iterator dry = dry_.begin();
  for (size_t e = 0; e < effects_.size(); ++e) {
    const EffectFacts& effect = effects_[e].facts();
    const VectorXd& c = effect.term().axis.coefficients;
    const std::vector<AxisSample> samples = effects_[e].samples(motion(), rigid);
    const VectorXd forces =
        effects_[e].next(samples) * Eigen::Map<const VectorXd>(effect.values().data(), effect.parameter_count());
    torque += forces * c.transpose();
    out.parts.col(2) += forces.cwiseAbs().mean() * c.cwiseAbs();
    if (dry == dry_.end() || dry->effect != e) continue;
    for (Eigen::Index k = 0; k < forces.size(); ++k) {
      const AxisSample& s = samples[static_cast<size_t>(k)];
      dry->level = std::max(dry->level, std::abs(forces[k]));
      dry->fastest = std::max(dry->fastest, std::abs(s.ds));
      if (std::abs(s.ds) < std::max(numbers_.rest_share * dry->fastest, spacing * std::abs(s.dds)))
        undetermined += dry->level / rows * c.cwiseAbs();
    }
    ++dry;
  }
  out.rest_friction2 = undetermined.cwiseAbs2();
}

// Torques per unit of every hypothesis, in their order: along axes, of channels, masses, and first moments of these.
void Hypotheses::add_columns(const MatrixXd& torque, double dt, Step& out) {
  out.columns = MatrixXd::Zero(arm_.joints(), static_cast<Eigen::Index>(all_.size()));
  Eigen::Index h = 0;
  for (ColumnsInPieces& effect : axis_)
    out.columns(main_coordinate(effect.facts().term().axis).value, h++) = effect.next(effect.samples(motion(), MatrixXd())).col(0).mean();
  const ChannelMotion along{arm_, bodies_, phi_, q_, dq_, ddq_, torque, dt};
  for (const ChannelEffect* channel : channel_) {
    const std::optional<JointIndex> joint = all_[static_cast<size_t>(h)].of.joint;
    out.columns.col(h) = channel->columns(along, joint).front().colwise().mean().transpose();
    for (int i = 0; i < arm_.joints(); ++i) {
      if (!channel->acts_on(i, joint)) out.columns(i, h) = 0.0;
    }
    ++h;
  }
  loads_.evaluate(q_, dq_, ddq_, Y_);
  const auto loads = static_cast<Eigen::Index>(body_of_load_.size());
  for (int i = 0; i < arm_.joints(); ++i) {
    const Eigen::RowVectorXd mean = Y_[i].colwise().mean();
    const std::vector<int>& of_joint = loads_.columns({i});
    for (Eigen::Index l = 0; l < loads; ++l) {
      const int first = kBodyParameters * body_of_load_[l];
      const auto at = std::lower_bound(of_joint.begin(), of_joint.end(), first);
      if (at == of_joint.end() || *at != first) continue;  // it does not move this body
      const auto mass = at - of_joint.begin();
      out.columns(i, h + l) = mean[mass];
      out.columns.block(i, h + loads + 3 * l, 1, 3) = mean.segment(mass + 1, 3);
    }
  }
}

}  // namespace veridyn::watching
