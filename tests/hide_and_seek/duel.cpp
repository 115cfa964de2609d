#include "hide_and_seek/duel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "hide_and_seek/judge.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/excitation/excitation.hpp"
#include "recordings/recorded_motion.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn::seek {
namespace {

constexpr int kFirstDesigned = 200;   // number of the first designed recording
constexpr double kFineRate = 1000.0;  // [Hz] of the designed motions before they are recorded
constexpr double kFrequencies[] = {0.1, 0.13, 0.08, 0.16};  // [Hz] of the designed motions

bool names(const NamedFinding& f, const std::string& effect) {
  return f.effect == effect;
}

// The other cause of a pair; where both are of a joint, one elsewhere is no rival but a mistake of
// its own.
bool is_other(const NamedFinding& f, const std::string& other, const Cause& cause) {
  return names(f, other) && (cause.joint < 0 || f.joint < 1 || f.joint == cause.joint + 1);
}

bool lists(const NamedFinding& f, const std::string& effect) {
  return std::any_of(f.rivals.begin(), f.rivals.end(),
                     [&](const Named& r) { return r.effect == effect; });
}

// The name of the frame that moves a frame: all that are fixed to it carry the same loads.
std::string link_of(const Model& arm, const std::string& frame) {
  const int found = arm.find_frame(frame);
  std::optional<FrameIndex> k;
  if (found >= 0) k = FrameIndex{found};
  while (k && arm.frames()[k->value].type == JointType::kFixed) k = arm.frames()[k->value].parent;
  return k ? arm.frames()[k->value].name : "";
}

// A load's finding stands for all links that carry it alike: they are among its rivals.
bool is_at(const Model& arm, const Cause& cause, const NamedFinding& f) {
  if (cause.effect == "payload") {
    const auto there = [&](const std::string& frame) {
      return link_of(arm, frame) == link_of(arm, cause.frame);
    };
    return there(f.frame) ||
           std::any_of(f.rivals.begin(), f.rivals.end(), [&](const Named& r) {
             return r.effect == cause.effect && there(r.frame);
           });
  }
  return cause.joint < 0 || f.joint == cause.joint + 1;
}

// A rival stands where the finding does, or on a frame, or is of the whole arm.
Answer answer(const Model& arm, const Diagnosis& d, const Cause& cause, const std::string& other) {
  bool right = false;
  bool right_elsewhere = false;
  bool both = false;
  bool wrong = false;
  for (const NamedFinding& f : named_by(d)) {
    const bool of_pair = names(f, cause.effect) || is_other(f, other, cause);
    if (names(f, cause.effect)) (is_at(arm, cause, f) ? right : right_elsewhere) = true;
    wrong |= is_other(f, other, cause);
    if (of_pair) both |= lists(f, names(f, other) ? cause.effect : other);
  }
  both |= right && wrong;
  if (both) return Answer::kBoth;
  if (right) return Answer::kRight;
  if (wrong) return Answer::kWrong;
  return right_elsewhere ? Answer::kElsewhere : Answer::kNothing;
}

// The kind that is named beside the hidden one, as far as a motion can be asked for it.
std::string rival_of(const Model& arm, const Diagnosis& d, const Cause& cause) {
  for (const NamedFinding& f : named_by(d)) {
    if (f.effect != cause.effect || !is_at(arm, cause, f)) continue;
    for (const Named& r : f.rivals) {
      const bool can =
          has_axis_effect(r.effect)
              ? !find_effect(r.effect).traits().uses_source
              : r.effect == "payload" || r.effect == "torque_gain" || r.effect == "gravity_tilt";
      if (can && r.effect != f.effect) return r.effect;
    }
  }
  return "";
}

std::string words(const Diagnosis& d) {
  std::string out;
  for (const NamedFinding& f : named_by(d)) {
    out += fmt::format("{}{}@{}", out.empty() ? "" : ", ", f.effect,
                       f.frame.empty() ? std::to_string(f.joint) : f.frame);
    for (const Named& r : f.rivals)
      out += fmt::format("/{}@{}", r.effect, r.frame.empty() ? std::to_string(r.joint) : r.frame);
  }
  return out.empty() ? "none" : out;
}

std::string place_text(const std::string& effect, int joint, const std::string& frame) {
  if (!frame.empty()) return effect + ":" + frame;
  return joint > 0 ? effect + ":" + std::to_string(joint) : effect;
}

// The two causes as the tool prints them; where it asks about others first, from the findings.
std::string between_of(const Diagnosis& d, const Pair& pair, bool& from_tool) {
  const std::vector<veridyn::Cause>& next = d.next_experiment.between;
  from_tool = false;
  if (next.size() == 2) {
    const Model& arm = *d.baseline.model;
    const std::string asked = to_text(arm, next[0]) + "," + to_text(arm, next[1]);
    from_tool =
        asked.find(pair.first) != std::string::npos && asked.find(pair.second) != std::string::npos;
    if (from_tool) return asked;
  }
  for (const NamedFinding& f : named_by(d)) {
    for (const Named& r : f.rivals) {
      const bool forth = f.effect == pair.first && r.effect == pair.second;
      const bool back = f.effect == pair.second && r.effect == pair.first;
      if (!forth && !back) continue;
      return place_text(f.effect, f.joint, f.frame) + "," + place_text(r.effect, r.joint, r.frame);
    }
  }
  return "";
}

// As with `--model M`: torques are not limited, for nobody knows how strong the arm is.
Model without_efforts(const Model& arm) {
  ModelDescription description = arm.description();
  for (Coordinate& c : description.coordinates)
    c.limits.effort = std::numeric_limits<double>::infinity();
  return Model(std::move(description));
}

// Friction shows itself at low speed and after reversals.
bool shows_when_slow(const veridyn::Cause& cause) {
  for (const char* effect : {"stribeck_friction", "presliding_hysteresis", "backlash"}) {
    if (effect_of(cause) == effect) return true;
  }
  return false;
}

class Fight {
 public:
  Fight(const DuelRequest& request, const std::string& folder)
      : request_(request),
        folder_(folder),
        hidden_(hide({request.arm,
                      {request.hide_second ? request.pair.second : request.pair.first},
                      request.seed,
                      request.share,
                      request.pair.mode})) {}

  Duel run() {
    Duel out;
    out.observable = hidden_.observable;
    if (!hidden_.observable) return out;
    const Cause& cause = hidden_.causes.front();
    const std::string& other = request_.hide_second ? request_.pair.first : request_.pair.second;
    const Model& robot = hidden_.bench.robot;
    out.hidden = describe(cause, robot);
    CaseFiles files = write_case(hidden_, folder_, request_.reach);
    files.train.resize(request_.ordinary, files.train.back());
    const Diagnosis before = ask(files);
    out.before = answer(robot, before, cause, other);
    out.words_before = words(before);
    Pair pair{cause.effect, other, request_.pair.mode};
    if (out.before == Answer::kRight) {
      // Not this pair, but perhaps the hidden cause and something else.
      pair.second = rival_of(robot, before, cause);
      out.other = pair.second;
    }
    if (out.before != Answer::kBoth && out.other.empty()) return out;
    out.asked = between_of(before, pair, out.from_tool);
    if (out.asked.empty()) return out;
    if (!design(before, files, out)) return out;
    const Diagnosis after = ask(files);
    out.after = answer(robot, after, cause, pair.second);
    out.words_after = words(after);
    return out;
  }

 private:
  Diagnosis ask(const CaseFiles& files) {
    DiagnosisOptions options;
    options.identification.threads = request_.threads;
    return seek_causes(hidden_, files, folder_, options);
  }

  // Adds recordings of designed motions to `files`.
  bool design(const Diagnosis& before, CaseFiles& files, Duel& out) {
    ExcitationOptions options;
    options.criterion = ExcitationCriterion::kDiscriminate;
    const auto comma = out.asked.find(',');
    options.rate = kFineRate;
    options.threads = request_.threads;
    options.powered = without_efforts(*before.extended.model);
    options.between = {parse_cause(*options.powered, out.asked.substr(0, comma)),
                       parse_cause(*options.powered, out.asked.substr(comma + 1))};
    const auto& [first, second] = *options.between;
    if (shows_when_slow(first) || shows_when_slow(second)) options.slow_passes = request_.slow_passes;
    for (const std::string& path : files.train) {
      for (const MotionSamples& motion : recorded_motion(hidden_.bench.robot, path))
        options.given.push_back(motion);
    }
    std::vector<std::string> recorded;
    for (int k = 0; k < request_.designs; ++k) {
      options.frequency = kFrequencies[k % 4];
      options.seed = request_.seed + static_cast<unsigned>(k);
      const Excitation found = optimise_excitation(hidden_.bench.robot, options);
      out.design_seconds += found.seconds;
      if (found.status == ExcitationStatus::kLimitsNotMet) return false;
      if (k == 0 && found.discrimination) {
        out.share_after =
            std::min(found.discrimination->first_share, found.discrimination->second_share);
      }
      recorded.push_back(record(found.motion, kFirstDesigned + 2 * k));
      if (k == 0) files.test.push_back(record(found.motion, kFirstDesigned + 1));
    }
    files.train.insert(files.train.end(), recorded.begin(), recorded.end());
    out.planned = true;
    return true;
  }

  std::string record(const MotionSamples& wanted, int number) {
    const Motion motion(hidden_.bench.robot, {wanted.time, wanted.q, wanted.dq, wanted.ddq},
                        hidden_.bench.seed, number);
    const std::string path = folder_ + fmt::format("/designed-{}.csv", number);
    write_recording(hidden_.bench, ideal_recording(hidden_.bench, hidden_.causes, motion, number),
                    hidden_.bench.seed, number, path);
    return path;
  }

  DuelRequest request_;
  std::string folder_;
  HiddenCase hidden_;
};

}  // namespace

const std::vector<Pair>& rival_pairs() {
  static const std::vector<Pair> kPairs = {
      {"position_dependent_friction", "load_dependent_friction", Mode::kBare},
      {"payload", "torque_gain", Mode::kChanged},
      {"rotor_inertia", "payload", Mode::kChanged},
      {"stribeck_friction", "presliding_hysteresis", Mode::kBare},
      {"joint_spring", "gravity_tilt", Mode::kBare},
      {"backlash", "transmission_compliance", Mode::kBare}};
  return kPairs;
}

const char* name_of(Answer answer) {
  switch (answer) {
    case Answer::kNothing:
      return "nothing";
    case Answer::kBoth:
      return "both";
    case Answer::kRight:
      return "right";
    case Answer::kWrong:
      return "wrong";
    case Answer::kElsewhere:
      break;
  }
  return "elsewhere";
}

Duel fight(const DuelRequest& request, const std::string& folder) {
  return Fight(request, folder).run();
}

}  // namespace veridyn::seek
