#include "watch/hypotheses.hpp"

#include <algorithm>
#include <cmath>

#include "model/suggestion.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::watching {
namespace {

// Of the largest speed, below which dry friction is undetermined.
constexpr double kRestShare = 0.03;

// Effects that exist on every joint and vary from day to day.
std::vector<const AxisEffect*> axis_effects_watched() {
  std::vector<const AxisEffect*> out;
  for (const AxisEffect* effect : axis_effects())
    if (effect->traits().elementary) out.push_back(effect);
  return out;
}

// Sensor errors of one joint that may begin during operation.
std::vector<const ChannelEffect*> channel_effects_watched() {
  std::vector<const ChannelEffect*> out;
  for (const ChannelEffect* effect : channel_effects()) {
    const auto* sensor = dynamic_cast<const SensorError*>(effect);
    if (sensor != nullptr && sensor->may_begin_suddenly()) out.push_back(sensor);
  }
  return out;
}

std::string unit_on(const Effect& effect, const Coordinate& c) {
  const EffectParameter p = effect.parameters().front();
  return c.prismatic ? p.unit_prismatic : p.unit_revolute;
}

bool is_last(const Model& arm, int frame) {
  return std::none_of(arm.frames().begin(), arm.frames().end(),
                      [frame](const Frame& f) { return f.parent == frame; });
}

std::vector<int> load_frames(const Model& arm, const std::vector<std::string>& links) {
  std::vector<int> out;
  for (const std::string& link : links) {
    std::vector<std::string> names;
    for (const Frame& f : arm.frames()) names.push_back(f.name);
    const int k = arm.find_frame(link);
    require(k >= 0, "watch: robot '", arm.name(), "' has no frame '", link, "'",
            did_you_mean(link, names), ".");
    out.push_back(k);
  }
  for (int k = 0; links.empty() && k < static_cast<int>(arm.frames().size()); ++k) {
    bool moves = false;
    for (int i = 0; i < arm.joints(); ++i) moves = moves || arm.moves(k, i);
    if (moves && (is_last(arm, k) || arm.frames()[static_cast<size_t>(k)].body)) out.push_back(k);
  }
  return out;
}

// The arm with an additional body on each of the frames.
Model with_bodies(const Model& arm, const std::vector<int>& frames) {
  ModelDescription d = arm.description();
  d.effects.clear();
  for (const int k : frames) {
    std::optional<Body>& body = d.frames[static_cast<size_t>(k)].body;
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

Hypotheses::Hypotheses(const Model& arm, const std::vector<std::string>& links)
    : arm_(arm),
      loaded_(with_bodies(arm, load_frames(arm, links))),
      bodies_(arm),
      loads_(loaded_),
      phi_(values_of(arm)) {
  for (const EffectTerm& term : arm.effects()) {
    if (!has_axis_effect(term.effect)) continue;
    effects_.emplace_back(arm, term);
    require(effects_.back().has_values() || effects_.back().parameter_count() == 0, "watch: robot '",
            arm.name(), "': ", effects_.back().parameter_name(0),
            " has no value, expected a MODEL that identify or diagnose wrote.");
    if (effects_.back().traits().dry != DryFriction::kNone) dry_.push_back({effects_.size() - 1});
  }
  const int n = arm.joints();
  for (const AxisEffect* effect : axis_effects_watched()) {
    for (int j = 0; j < n; ++j) {
      EffectTerm term;
      term.effect = effect->name();
      term.axis.coefficients = VectorXd::Unit(n, j);
      const Coordinate& c = arm.coordinates()[static_cast<size_t>(j)];
      axis_.emplace_back(arm, term);
      all_.push_back({effect->name(), c.name, j, -1, unit_on(*effect, c)});
    }
  }
  for (const ChannelEffect* effect : channel_effects_watched()) {
    for (int j = effect->can_be_common() && n > 1 ? kAllJoints : 0; j < n; ++j) {
      const bool common = j == kAllJoints;
      const Coordinate& c = arm.coordinates()[static_cast<size_t>(common ? 0 : j)];
      channel_.push_back(effect);
      all_.push_back({effect->name(), common ? "arm" : c.name, j, -1, unit_on(*effect, c)});
    }
  }
  for (const int k : load_frames(arm, links)) {
    const auto at = std::find(loaded_.bodies().begin(), loaded_.bodies().end(), k);
    body_of_load_.push_back(static_cast<int>(at - loaded_.bodies().begin()));
    all_.push_back({AddedLoad::kName, arm.frames()[static_cast<size_t>(k)].name, kAllJoints, k, "kg"});
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
  for (BoundEffect& effect : effects_) effect.reset();
  for (BoundEffect& effect : axis_) effect.reset();
}

void Hypotheses::add_effects(const StepMotion& motion, const MatrixXd& rigid, Answer& out) {
  const Eigen::Index rows = motion.q.rows();
  std::vector<Dry>::iterator dry = dry_.begin();
  for (size_t e = 0; e < effects_.size(); ++e) {
    BoundEffect& effect = effects_[e];
    const VectorXd& c = effect.term().axis.coefficients;
    Dry* of_effect = dry != dry_.end() && dry->effect == e ? &*dry++ : nullptr;
    for (Eigen::Index k = 0; k < rows; ++k) {
      AxisSample x = effect.sample(motion.time[k], motion.q.data() + k, motion.dq.data() + k,
                                   motion.ddq.data() + k, rows);
      if (effect.traits().uses_load) x.load = rigid.row(k).dot(c) / c.squaredNorm();
      const double force = effect.force(x);
      out.torque.row(k) += force * c.transpose();
      out.parts[2].row(k) += std::abs(force) * c.transpose().cwiseAbs();
      if (of_effect == nullptr) continue;
      of_effect->level = std::max(of_effect->level, std::abs(force));
      of_effect->fastest = std::max(of_effect->fastest, std::abs(x.ds));
      if (std::abs(x.ds) < kRestShare * of_effect->fastest)
        out.rest_friction.row(k) += (of_effect->level * c.transpose()).cwiseAbs();
    }
  }
}

void Hypotheses::channel_columns(const StepMotion& motion, Answer& out) const {
  const double dt = motion.time.size() > 1 ? motion.time[1] - motion.time[0] : 1.0;
  const ChannelMotion along{arm_, bodies_, phi_, motion.q, motion.dq, motion.ddq, out.torque, dt};
  for (size_t h = 0; h < channel_.size(); ++h) {
    const int joint = all_[axis_.size() + h].joint;
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
  for (BoundEffect& effect : axis_) {
    MatrixXd column = MatrixXd::Zero(rows, n);
    const int j = main_coordinate(effect.term().axis);
    EffectColumns row{};
    for (Eigen::Index k = 0; k < rows; ++k) {
      effect.columns(effect.sample(motion.time[k], motion.q.data() + k, motion.dq.data() + k,
                                   motion.ddq.data() + k, rows), row);
      column(k, j) = row[0];
    }
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
    if (at != of_joint.end()) column.col(i) = Y_[static_cast<size_t>(i)].col(at - of_joint.begin());
  }
  return column;
}

}  // namespace veridyn::watching
