#include "diagnosis/watch/hypotheses.hpp"

#include <algorithm>
#include <cmath>

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

bool is_last(const Model& arm, int frame) {
  return std::none_of(arm.frames().begin(), arm.frames().end(),
                      [frame](const Frame& f) { return f.parent == FrameIndex{frame}; });
}

std::vector<FrameIndex> load_frames(const Model& arm, const std::vector<std::string>& links) {
  std::vector<FrameIndex> out;
  for (const std::string& link : links) {
    const FrameIndex frame = find_frame(arm, link, "watch: robot '" + arm.name() + "'");
    if (std::find(out.begin(), out.end(), frame) == out.end()) out.push_back(frame);
  }
  for (int k = 0; links.empty() && k < static_cast<int>(arm.frames().size()); ++k) {
    bool moves = false;
    for (int i = 0; i < arm.joints(); ++i) moves = moves || arm.moves(k, i);
    if (moves && (is_last(arm, k) || arm.frames()[k].body)) out.push_back({k});
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

MotionView view(const StepMotion& m) { return {m.time, m.q, m.dq, m.ddq}; }

}  // namespace

Hypotheses::Hypotheses(const Model& arm, const std::vector<std::string>& links, const WatchNumbers& numbers)
    : numbers_(numbers),
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
      const auto at = std::find(loaded_.bodies().begin(), loaded_.bodies().end(), frame_of(c.cause)->value);
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

void Hypotheses::reset() {
  for (ColumnsInPieces& effect : effects_) effect.reset();
  for (ColumnsInPieces& effect : axis_) effect.reset();
}

void Hypotheses::add_effects(const StepMotion& motion, const MatrixXd& rigid, Answer& out) {
  const Eigen::Index rows = motion.q.rows();
  std::vector<Dry>::iterator dry = dry_.begin();
  for (size_t e = 0; e < effects_.size(); ++e) {
    const EffectFacts& effect = effects_[e].facts();
    const VectorXd& c = effect.term().axis.coefficients;
    const std::vector<AxisSample> samples = effects_[e].samples(view(motion), rigid);
    const VectorXd forces =
        effects_[e].next(samples) * Eigen::Map<const VectorXd>(effect.values().data(), effect.parameter_count());
    Dry* of_effect = dry != dry_.end() && dry->effect == e ? &*dry++ : nullptr;
    for (Eigen::Index k = 0; k < rows; ++k) {
      const double force = forces[k];
      const double speed = std::abs(samples[k].ds);
      out.torque.row(k) += force * c.transpose();
      out.parts[2].row(k) += std::abs(force) * c.transpose().cwiseAbs();
      if (of_effect == nullptr) continue;
      of_effect->level = std::max(of_effect->level, std::abs(force));
      of_effect->fastest = std::max(of_effect->fastest, speed);
      if (speed < std::max(numbers_.rest_share * of_effect->fastest, motion.spacing * std::abs(samples[k].dds)))
        out.rest_friction.row(k) += (of_effect->level * c.transpose()).cwiseAbs();
    }
  }
}

void Hypotheses::channel_columns(const StepMotion& motion, Answer& out) const {
  const double dt = motion.time.size() > 1 ? motion.time[1] - motion.time[0] : 1.0;
  const ChannelMotion along{arm_, bodies_, phi_, motion.q, motion.dq, motion.ddq, out.torque, dt};
  for (size_t h = 0; h < channel_.size(); ++h) {
    const std::optional<JointIndex> joint = all_[axis_.size() + h].of.joint;
    MatrixXd column = channel_[h]->columns(along, joint).front();
    for (int i = 0; i < arm_.joints(); ++i) {
      if (!channel_[h]->acts_on(i, joint)) column.col(i).setZero();
    }
    out.columns.push_back(std::move(column));
  }
}

void Hypotheses::evaluate(const StepMotion& motion, Answer& out) {
  const Eigen::Index rows = motion.q.rows();
  const int n = arm_.joints();
  bodies_.torques(motion.q, motion.dq, motion.ddq, phi_, out.torque);
  out.rest_friction = MatrixXd::Zero(rows, n);
  out.columns.clear();
  const MatrixXd rigid = out.torque;
  const MatrixXd still = MatrixXd::Zero(rows, n);
  MatrixXd weight;
  bodies_.torques(motion.q, still, still, phi_, weight);
  out.parts = {weight.cwiseAbs(), (rigid - weight).cwiseAbs(), still};
  add_effects(motion, rigid, out);
  for (ColumnsInPieces& effect : axis_) {
    MatrixXd column = MatrixXd::Zero(rows, n);
    column.col(main_coordinate(effect.facts().term().axis)) =
        effect.next(effect.samples(view(motion), MatrixXd())).col(0);
    out.columns.push_back(std::move(column));
  }
  channel_columns(motion, out);
  loads_.evaluate(motion.q, motion.dq, motion.ddq, Y_);
  for (const int body : body_of_load_) out.columns.push_back(load_column(body, 0, rows));
  for (const int body : body_of_load_)
    for (int moment = 1; moment <= 3; ++moment)
      out.columns.push_back(load_column(body, moment, rows));
}

// Torque per unit of one inertial parameter of a body of loaded_.
MatrixXd Hypotheses::load_column(int body, int parameter, Eigen::Index rows) const {
  MatrixXd column = MatrixXd::Zero(rows, arm_.joints());
  for (int i = 0; i < arm_.joints(); ++i) {
    const std::vector<int>& of_joint = loads_.columns(i);
    const auto at =
        std::find(of_joint.begin(), of_joint.end(), kBodyParameters * body + parameter);
    if (at != of_joint.end()) column.col(i) = Y_[i].col(at - of_joint.begin());
  }
  return column;
}

}  // namespace veridyn::watching
