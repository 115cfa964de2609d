#include "veridyn/diagnosis/friction_study.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "diagnosis/numerics.hpp"
#include "effects/plain_friction.hpp"
#include "identification/check/answers.hpp"
#include "recordings/breakaway_ramps.hpp"
#include "recordings/named_recordings.hpp"
#include "recordings/steady_runs.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/fixed_coordinates.hpp"

namespace veridyn {
namespace {

constexpr double kDiagnosis = 0.5;  // share of the work, for progress

// Joints that travel in some recording; mean positions of the others, by the names of their coordinates.
struct Travel {
  std::vector<int> moving;
  std::map<std::string, double> held;
};

Travel travel_of(const Model& arm, const std::vector<Recording>& recordings) {
  Travel out;
  for (int i = 0; i < arm.joints(); ++i) {
    double low = numerics::kHuge, high = -numerics::kHuge, sum = 0.0, count = 0.0;
    for (const Recording& r : recordings) {
      for (const double q : r.q.col(i)) {
        if (!std::isfinite(q)) continue;
        low = std::min(low, q);
        high = std::max(high, q);
        sum += q;
        count += 1.0;
      }
    }
    const Coordinate& c = arm.coordinates()[i];
    if (travels_far_enough(low, high, c.prismatic)) {
      out.moving.push_back(i);
    } else {
      out.held[c.name] = rounded_hold_position(count > 0.0 ? sum / count : 0.0, c.prismatic);
    }
  }
  return out;
}

Recording with_joints_only(const Recording& r, const std::vector<int>& joints) {
  Recording out = r;
  for (const RecordingSignal& signal : kRecordingSignals) {
    const MatrixXd& all = r.*signal.values;
    if (all.cols() == 0) continue;
    MatrixXd& some = out.*signal.values;
    some.resize(all.rows(), static_cast<Eigen::Index>(joints.size()));
    for (size_t k = 0; k < joints.size(); ++k)
      some.col(k) = all.col(joints[k]);
  }
  return out;
}

// Recorded torques, or recorded currents times drive gains; empty without both.
MatrixXd torque_of(const Model& arm, const Recording& r) {
  if (r.tau.size() > 0 || r.current.size() == 0) return r.tau;
  MatrixXd tau = r.current;
  for (int i = 0; i < arm.joints(); ++i) tau.col(i) *= arm.coordinates()[i].drive_gain;
  return tau;
}

// The arm with friction and offsets to identify; bodies of an identified model stay fixed.
Model with_open_friction(const Model& arm) {
  ModelDescription d = arm.description();
  d.identified.reset();
  const bool facts = d.values == RobotValues::kFacts && arm.inertial_values();
  for (Frame& frame : d.frames) {
    if (frame.body) frame.body->fixed = facts || frame.body->fixed;
  }
  for (EffectTerm& term : d.effects) {
    if (term.fixed || !has_axis_effect(term.effect)) continue;
    const AxisEffect& effect = find_axis_effect(term.effect);
    if (effect.traits().role != EffectRole::kFriction && !effect.traits().elementary) continue;
    for (const EffectParameter& p : effect.parameters()) term.values.erase(p.name);
    term.deviations.clear();
  }
  return Model(std::move(d));
}

// Kinds of friction, and the errors of a joint's channels, which imitate them: a late torque looks like a backlash.
std::vector<std::string> friction_effect_names() {
  std::vector<std::string> out;
  for (const ChannelEffect* effect : channel_effects()) {
    if (dynamic_cast<const SensorError*>(effect) != nullptr) out.push_back(effect->name());
  }
  for (const AxisEffect* effect : axis_effects()) {
    const EffectTraits traits = effect->traits();
    if (traits.role == EffectRole::kFriction && !traits.elementary && !traits.tabulated)
      out.push_back(effect->name());
  }
  return out;
}

std::vector<Ramp> ramps_of(const Model& arm, const Recording& r, const MatrixXd& tau, int joint) {
  const Coordinate& c = arm.coordinates()[joint];
  const VectorXd q = r.q.col(joint), effort = tau.col(joint);
  return find_ramps(c, r.time, q, effort, ramp_thresholds(c));
}

// True if some joint breaks away while no joint slides in half of the rows or more.
bool is_of_ramps(const Model& arm, const Recording& r) {
  const MatrixXd tau = torque_of(arm, r);
  bool ramps = false;
  for (int i = 0; i < arm.joints(); ++i) {
    const double speed = ramp_thresholds(arm.coordinates()[i]).speed;
    if (sliding_share(r.time, r.q.col(i), speed) > 0.5) return false;
    ramps = ramps || (tau.size() > 0 && !ramps_of(arm, r, tau, i).empty());
  }
  return ramps;
}

// Torque at rest without friction: gravity, offsets, springs.
VectorXd torque_at_rest(const Model& arm, const VectorXd& q) {
  VectorXd tau(q.size());
  RigidBodyDynamics(arm, *arm.inertial_values()).gravity_torques(q, tau);
  const VectorXd still = VectorXd::Zero(q.size());
  for (const EffectTerm& term : arm.effects()) {
    if (!term.frame.empty() || !has_axis_effect(term.effect)) continue;
    const EffectFacts effect(arm, term);
    if (effect.traits().role != EffectRole::kForce || effect.traits().memory) continue;
    tau += effect.force_at(effect.sample(0.0, q.data(), still.data(), still.data(), 1)) * term.axis.coefficients;
  }
  return tau;
}

// Direction of the displacement: its mean over a tenth of a second, since the joint may still be at rest at
// its onset.
int direction_of(const VectorXd& q, const Ramp& ramp, double way) {
  Eigen::Index k = ramp.onset;
  while (k + 1 < ramp.end && std::abs(q[k] - q[ramp.rest]) <= way) ++k;
  return q[k] > q[ramp.rest] ? 1 : -1;
}

// Adds the breakaways of a joint in one recording.
void add_breakaways(const Model& arm, const Recording& r, int joint,
                    std::vector<FrictionBreakaway>& out) {
  const MatrixXd tau = torque_of(arm, r);
  if (tau.size() == 0) return;
  for (const Ramp& ramp : ramps_of(arm, r, tau, joint)) {
    FrictionBreakaway one;
    one.source = r.source;
    one.time = r.time[ramp.onset] - r.time[0];
    one.direction = direction_of(r.q.col(joint), ramp, ramp_thresholds(arm.coordinates()[joint]).way);
    const VectorXd q = r.q.row(ramp.rest).transpose();
    one.torque = effort_at(r.time, tau.col(joint), ramp.onset) - torque_at_rest(arm, q)[joint];
    out.push_back(one);
  }
}

// Mean friction of the segments of nearly constant speed; segments of similar speed are merged.
std::vector<FrictionAtSpeed> friction_at_held_speeds(const Identification& id, const FrictionCurve& curve) {
  struct Run {
    FrictionAtSpeed mean;
    double squares = 0.0, samples = 0.0;
  };
  std::vector<Run> runs;
  for (const RecordingError& recording : id.train) {
    const PredictionSeries& s = recording.series;
    const auto joint = static_cast<size_t>(curve.joint.value);
    for (const SteadyRun& run : steady_runs(s.time, s.dq[joint])) {
      Run one;
      one.samples = static_cast<double>(run.end - run.from);
      one.mean = {run.velocity, 0.0, 0.0, s.time[run.end - 1] - s.time[run.from], 1};
      for (size_t k = run.from; k < run.end; ++k) {
        const double left = s.measured[joint][k] - s.modelled[joint][k] + curve.at(s.dq[joint][k]);
        one.mean.torque += left / one.samples;
        one.squares += left * left;
      }
      runs.push_back(one);
    }
  }
  std::sort(runs.begin(), runs.end(),
            [](const Run& a, const Run& b) { return a.mean.velocity < b.mean.velocity; });
  std::vector<FrictionAtSpeed> out;
  for (size_t k = 0; k < runs.size();) {
    FrictionAtSpeed sum;
    double squares = 0.0, samples = 0.0;
    const double first = runs[k].mean.velocity;
    for (; k < runs.size() && same_speed(first, runs[k].mean.velocity); ++k) {
      const Run& run = runs[k];
      sum.velocity += run.samples * run.mean.velocity;
      sum.torque += run.samples * run.mean.torque;
      sum.seconds += run.mean.seconds;
      ++sum.runs;
      squares += run.squares;
      samples += run.samples;
    }
    sum.velocity /= samples;
    sum.torque /= samples;
    sum.deviation = std::sqrt(std::max(0.0, squares / samples - sum.torque * sum.torque));
    out.push_back(sum);
  }
  return out;
}

std::vector<FrictionVerdict> verdicts_of(const Diagnosis& d, int joint) {
  const Model& arm = *d.baseline.model;
  const auto here = [&](const Cause& cause) {
    const std::optional<JointIndex> at = acting_joint(arm, cause);
    return at && at->value == joint;
  };
  std::vector<FrictionVerdict> out;
  for (const Finding& f : d.findings) {
    const bool is_of_all = !acting_joint(arm, f.cause);  // a common clock
    if (!here(f.cause) && !is_of_all) continue;
    out.push_back({f.shape ? UnnamedShape::kName : effect_of(f.cause),
                   f.status == FindingStatus::kConfirmed ? FrictionState::kConfirmed
                                                         : FrictionState::kNotConfirmed,
                   f.p_value, f.parameters, f.phrase});
  }
  for (const NotSupported& n : d.not_supported) {
    if (here(n.cause))
      out.push_back({effect_of(n.cause), FrictionState::kNotSupported, n.p_value, {}, n.why});
  }
  for (const CannotTell& c : d.cannot_tell) {
    if (c.cause && here(*c.cause))
      out.push_back({c.effect, FrictionState::kCannotTell, std::nullopt, {}, c.why});
  }
  return out;
}

// Mends the recordings as diagnose() did.
void mend(const Model& arm, std::vector<Recording>& sliding, std::vector<Recording>& all, IdentificationOptions how) {
  std::vector<std::string> train, every;
  for (const auto& [list, names] : {std::pair(&sliding, &train), std::pair(&all, &every)}) {
    for (const Recording& r : *list) {
      how.preprocessing.in_memory[r.source] = std::make_shared<const Recording>(r);
      names->push_back(r.source);
    }
  }
  const MendedSetUp set_up = mended_set_up(arm, train, every, how.preprocessing, identify(arm, train, {}, how));
  for (std::vector<Recording>* list : {&sliding, &all}) {
    for (Recording& r : *list)
      if (const Recording* mended = find_in_memory(set_up.recordings, r.source)) r = *mended;
  }
}

}  // namespace

const char* name_of(FrictionState state) {
  switch (state) {
    case FrictionState::kConfirmed: return "confirmed";
    case FrictionState::kNotConfirmed: return "not_confirmed";
    case FrictionState::kNotSupported: return "not_supported";
    case FrictionState::kCannotTell: break;
  }
  return "cannot_tell";
}

FrictionStudy study_friction(const Model& arm, const Recordings& recordings, const Recordings& test,
                             const DiagnosisOptions& options) {
  FrictionStudy out;
  out.robot = arm.name();
  NamedRecordings<IdentificationOptions> named(recordings, test, options.identification);
  keep_recordings(named.how, KeptRecordings::kManyQuestions);
  const RecordingOptions reading = recording_options_for(arm, named.how.preprocessing);
  const auto read = [&](const std::vector<std::string>& names) {
    std::vector<Recording> rows;
    for (const std::string& name : names) {
      const Recording* there = find_in_memory(named.how.preprocessing.in_memory, name);
      rows.push_back(there != nullptr ? *there : read_rows(name, reading, named.how.preprocessing.kept.get()));
      rows.back().source = name;
      require(rows.back().joints() == arm.joints(), name, ": found ", rows.back().joints(),
              " joints, expected the ", arm.joints(), " of robot '", arm.name(), "'.");
    }
    return rows;
  };
  std::vector<Recording> all = read(named.train), held_out = read(named.test);
  std::vector<Recording> both = all;
  both.insert(both.end(), held_out.begin(), held_out.end());
  const Travel travel = travel_of(arm, both);
  for (const auto& [name, position] : travel.held) out.resting.push_back(name);
  if (travel.moving.empty()) {
    out.reason = "no joint moves by 20 mrad or 2 mm";
    return out;
  }
  const Model open = with_open_friction(with_fixed(arm, travel.held));
  for (std::vector<Recording>* list : {&all, &held_out, &both})
    for (Recording& r : *list) r = with_joints_only(r, travel.moving);
  all.erase(std::remove_if(all.begin(), all.end(), [&](const Recording& r) { return is_of_ramps(open, r); }),
            all.end());
  if (all.empty()) {
    out.reason = "all recordings rest during most of their time: expected one in which a joint slides";
    return out;
  }
  std::vector<Recording> train = all;
  if (held_out.empty() && train.size() > 1) {
    held_out.push_back(train.back());
    train.pop_back();
  } else if (held_out.empty()) {
    const int rows = train.front().rows(), last = rows / 3;
    held_out.push_back(rows_of(train.front(), rows - last, last));
    held_out.back().source += " (its last third)";
    train.front() = rows_of(train.front(), 0, rows - last);
  } else {
    all.insert(all.end(), held_out.begin(), held_out.end());
  }
  for (const Recording& r : held_out) out.held_out.push_back(r.source);

  DiagnosisOptions asked = options;
  asked.identification.preprocessing.kept = nullptr;  // columns were cut already
  asked.identification.preprocessing.signals = {};
  asked.identification.preprocessing.columns.clear();
  if (asked.effects.empty()) asked.effects = friction_effect_names();
  if (asked.identification.friction == JointFriction::kAuto && has_no_friction(open))
    asked.identification.friction = JointFriction::kPlain;
  const auto progress = asked.identification.progress;
  const auto part = [&progress](double from, double to) -> decltype(asked.identification.progress) {
    if (!progress) return {};
    return [&progress, from, to](const std::string& what, double share) {
      progress(what, from + (to - from) * share);
    };
  };
  asked.identification.progress = part(0.0, kDiagnosis);
  out.diagnosis = diagnose(open, train, held_out, asked);
  if (!out.diagnosis.baseline.model) {
    out.reason = out.diagnosis.baseline.reason;
    return out;
  }
  if (out.diagnosis.mended) mend(open, all, both, asked.identification);
  const Identification& found =
      out.diagnosis.extended.model ? out.diagnosis.extended : out.diagnosis.baseline;
  asked.identification.friction = JointFriction::kFile;
  asked.identification.progress = part(kDiagnosis, 1.0);
  out.fitted = identify(with_open_friction(*found.model), all, {}, asked.identification);
  if (!out.fitted.model) out.fitted = found;
  for (FrictionCurve& curve : friction_curves(out.fitted)) {
    JointFrictionStudy one;
    const int k = curve.joint.value;
    one.joint = {travel.moving[k]};
    const Coordinate& c = open.coordinates()[k];
    one.coordinate = c.name;
    one.unit = position_unit(c);
    one.effort = effort_unit(c);
    one.speeds = friction_at_held_speeds(out.fitted, curve);
    for (const Recording& r : both) add_breakaways(*out.fitted.model, r, k, one.breakaways);
    one.verdicts = verdicts_of(out.diagnosis, k);
    one.error_plain = out.diagnosis.baseline.test_error.relative[k];
    one.error = found.test_error.relative[k];
    one.curve = std::move(curve);
    out.joints.push_back(std::move(one));
  }
  return out;
}

}  // namespace veridyn
