#include "hide_and_seek/judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "model/moving_frame.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn::seek {
namespace {

bool is_on_a_frame(const std::string& effect) {
  return effect == "payload" || effect == "coupling_error";
}

Named named(const Diagnosis& d, const veridyn::Cause& cause, const std::string& why) {
  const CauseWords w = words_of(*d.baseline.model, cause);
  return {w.effect, w.joint ? w.joint->value + 1 : 0, w.frame, why};
}

bool matches(const Cause& cause, const NamedFinding& f) {
  if (f.effect != cause.effect) return false;
  if (is_on_a_frame(cause.effect)) return f.frame == cause.frame;
  return f.joint == cause.joint + 1;  // 0: the whole arm
}

// Rivals without a frame of their own have its name in the reason.
bool matches_rival(const Cause& cause, const Named& r) {
  if (r.effect != cause.effect) return false;
  if (is_on_a_frame(cause.effect))
    return r.frame == cause.frame || r.why.find(cause.frame) != std::string::npos;
  return r.joint == cause.joint + 1;
}

bool has_rival(const Cause& cause, const NamedFinding& f) {
  return std::any_of(f.rivals.begin(), f.rivals.end(),
                     [&](const Named& r) { return matches_rival(cause, r); });
}

// The straight part of a force of position is a spring of its own in CONTRACT.md.
bool is_part_of(const Cause& cause, const NamedFinding& f) {
  return cause.effect == "position_force" && f.effect == "joint_spring" &&
         f.joint == cause.joint + 1;
}

void compare_intervals(const Cause& cause, const NamedFinding& f, Verdict& v) {
  for (const FoundParameter& p : f.parameters) {
    // For changed friction, the change and the new value are both right.
    std::vector<double> truths;
    const auto found = cause.values.find(p.name);
    if (found != cause.values.end()) truths.push_back(found->second);
    const auto now = cause.values.find("now");
    if (now != cause.values.end() && !truths.empty()) truths.push_back(now->second);
    if (truths.empty() || p.name == "centre") continue;
    ++v.intervals;
    if (std::any_of(truths.begin(), truths.end(),
                    [&](double x) { return p.low <= x && x <= p.high; })) {
      ++v.covered;
    } else {
      v.outside += fmt::format("{} = {:.4g} not in [{:.4g}, {:.4g}]; ", p.name, truths.front(),
                               p.low, p.high);
    }
  }
}

// A load on any frame of a rigid body is the same load: a finding on one of them counts as on the hidden one. Its centre, in
// another frame, is not compared.
void put_on_hidden_frames(const Model& arm, const std::vector<Cause>& hidden, std::vector<NamedFinding>& findings) {
  const auto body = [&arm](const std::string& frame) { return moving_frame(arm, arm.find_frame(frame)); };
  for (const Cause& cause : hidden) {
    if (cause.effect != AddedLoad::kName) continue;
    const auto is_same_body = [&](const Named& one) {
      return one.effect == cause.effect && one.frame != cause.frame && body(one.frame) == body(cause.frame);
    };
    for (NamedFinding& f : findings) {
      for (Named& rival : f.rivals) {
        if (is_same_body(rival)) rival.frame = cause.frame;
      }
      if (!is_same_body(f)) continue;
      f.frame = cause.frame;
      f.parameters.erase(std::remove_if(f.parameters.begin(), f.parameters.end(), [](const FoundParameter& p) { return p.name != "mass"; }), f.parameters.end());
    }
  }
}

}  // namespace

std::vector<NamedFinding> named_by(const Diagnosis& d) {
  std::vector<NamedFinding> out;
  for (const Finding& f : d.findings) {
    NamedFinding one{named(d, f.cause, ""), f.parameters, {}};
    for (const Rival& r : f.rivals) one.rivals.push_back(named(d, r.cause, r.why));
    out.push_back(std::move(one));
  }
  return out;
}

Verdict judge(const std::vector<Cause>& hidden, const std::vector<NamedFinding>& findings,
              const std::vector<Cause>& also_true) {
  Verdict v;
  v.hidden = static_cast<int>(hidden.size());
  std::vector<char> right(findings.size(), 0);
  for (const Cause& cause : hidden) {
    bool named = false;
    bool loosely = false;
    for (size_t k = 0; k < findings.size(); ++k) {
      const NamedFinding& f = findings[k];
      loosely |= f.effect == cause.effect;
      if (is_part_of(cause, f)) right[k] = 1;
      if (!matches(cause, f)) continue;
      if (!named) compare_intervals(cause, f, v);
      named = true;
      right[k] = 1;
      v.first |= k == 0;
    }
    bool stand_in = false;
    for (size_t k = 0; k < findings.size(); ++k) {
      if (!has_rival(cause, findings[k])) continue;
      v.first_rival |= k == 0;
      if (!named && !stand_in) right[k] = 1;
      stand_in = true;
    }
    v.named += static_cast<int>(named);
    v.named_rival += static_cast<int>(named || stand_in);
    v.named_loosely += static_cast<int>(loosely);
  }
  for (const Cause& cause : also_true) {
    for (size_t k = 0; k < findings.size(); ++k) right[k] |= matches(cause, findings[k]) ? 1 : 0;
  }
  v.first_rival |= v.first;
  v.extras = static_cast<int>(std::count(right.begin(), right.end(), 0));
  return v;
}

Verdict judge(const HiddenCase& hidden, const Diagnosis& d) {
  std::vector<NamedFinding> findings = named_by(d);
  if (d.baseline.model) put_on_hidden_frames(*d.baseline.model, hidden.causes, findings);
  Verdict v = judge(hidden.causes, findings, hidden.also_true);
  const VectorXd& before = d.baseline.test_error.relative;
  const VectorXd& after = d.extended.test_error.relative;
  if (!hidden.causes.empty() && before.size() > 0 && after.size() == before.size()) {
    const int joint = hidden.causes.front().joint;
    v.error_ratio = joint >= 0 ? after[joint] / before[joint] : after.norm() / before.norm();
  }
  return v;
}

Model known_arm(const HiddenCase& hidden, const CaseFiles& files, const std::string& folder,
                const IdentificationOptions& options) {
  if (hidden.request.mode == Mode::kBare) return hidden.bench.robot;
  const Identification clean = identify(hidden.bench.robot, files.clean, {}, options);
  require(clean.model.has_value(), "hide and seek: ", hidden.request.arm,
          " could not be identified: ", clean.reason);
  const std::string model = folder + "/model.yaml";
  save(clean, model);
  return read_model(model);
}

Diagnosis seek_causes(const HiddenCase& hidden, const CaseFiles& files, const std::string& folder,
                      const DiagnosisOptions& options) {
  return diagnose(known_arm(hidden, files, folder, options.identification), files.train, files.test, options);
}

}  // namespace veridyn::seek
