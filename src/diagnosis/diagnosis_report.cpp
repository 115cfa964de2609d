#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "diagnosis/mistakes.hpp"
#include "diagnosis/numerics.hpp"
#include "identification/differing_recordings.hpp"
#include "identification/identification_numbers.hpp"
#include "model/correlated_joints.hpp"
#include "math/digits.hpp"
#include "veridyn/identification/robot_check.hpp"
#include "veridyn/identification/verdict.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {
namespace {

using numerics::kPercent;

std::string percent_cells(const VectorXd& v) {
  std::string out;
  for (Eigen::Index i = 0; i < v.size(); ++i)
    out += in_percent(v[i], numerics::kNumberWidth);
  return out;
}

// Width of a column that holds the longest name of a joint.
size_t table_width(const Model& arm) {
  size_t width = numerics::kNumberWidth;
  for (const Coordinate& c : arm.coordinates()) width = std::max(width, c.name.size() + 2);
  return width;
}

const char* state_words(const JointVerdict& v) {
  switch (v.state) {
    case JointState::kAtFloor: return "at its floor";
    case JointState::kNamed: return v.held_out - v.extended < numerics::kWhole * v.removable ? "named in part" : "named";
    case JointState::kUnnamed: return "without a name";
    case JointState::kCannotTell: return "these recordings cannot tell";
  }
  return "";
}

// "3 %"; a share above zero is never printed as "0 %".
std::string share_text(double share) {
  const double percent = kPercent * std::abs(share);
  return percent < 0.5 ? "less than 1 %" : fmt::format("{:.0f} %", percent);
}

std::string status_words(const Finding& f) {
  if (f.status == FindingStatus::kNotConfirmed)
    return "NOT CONFIRMED: parts of the training recordings that are held out are predicted no better with it";
  if (f.held_out() == Agreement::kContradicts)
    return "confirmed in training, yet the held-out recordings are predicted no better with it";
  if (f.explains < 0.0) return "confirmed on its own joint and in the mean over all joints";
  return "confirmed: explains " + share_text(f.explains) + " of the removable error";
}

std::string place_of_joint(const CauseWords& w) {
  return w.joint ? fmt::format(" on joint {} ({})", w.joint->value + 1, w.coordinate) : " of the whole arm";
}

std::string rival_text(const Diagnosis& d, const Rival& r) {
  const CauseWords w = words_of(*d.baseline.model, r.cause);
  return w.effect + (w.frame.empty() ? place_of_joint(w) : " on " + w.frame);
}

std::string finding_text(const Diagnosis& d, const Finding& f) {
  std::string out = fmt::format("{}. {}\n", f.rank, d.sentence(f));
  const char* of = std::holds_alternative<ChangedEffect>(f.cause) ? "change of " : "";
  const bool of_moment = std::any_of(f.parameters.begin(), f.parameters.end(), [](const FoundParameter& p) { return p.name == "moment"; });
  for (const FoundParameter& p : f.parameters) {
    if (of_moment && p.name == "mass" && p.low < 0.0 && p.high > 0.0) continue;  // the sentence reports that the mass is unknown
    out += fmt::format("     {}{} = {:.4g} {} (95 %: {:.4g} to {:.4g})\n", of, p.name, p.value, p.unit,
                       p.low, p.high);
  }
  if (f.test_outside.size() > 0) {
    out += fmt::format("     held-out error outside of what is left out, %: {}\n     p = {:.1e}\n",
                       percent_cells(f.test_outside), f.p_value);
  } else {
    out += fmt::format("     held-out error, %: {} -> {}\n", percent_cells(f.test_before),
                       percent_cells(f.test_after));
    out += fmt::format("     p = {:.1e}, {}\n", f.p_value, status_words(f));
  }
  for (const Rival& r : f.rivals) {
    out += fmt::format("     rival: {}: {}\n", rival_text(d, r), r.why);
  }
  return out;
}

// True if a finding does not begin with the error at which the one before it ends: findings are listed by
// size, in another order than they were added.
bool errors_jump(const Diagnosis& d) {
  const Finding* above = nullptr;
  for (const Finding& f : d.findings) {
    if (!f.main || f.test_before.size() == 0) continue;
    if (above != nullptr && percent_cells(above->test_after) != percent_cells(f.test_before)) return true;
    above = &f;
  }
  return false;
}

std::string small_finding_text(const Diagnosis& d, const Finding& f) {
  return fmt::format("{:>4}. {} p = {:.1e}, {}\n", f.rank, d.sentence(f), f.p_value, status_words(f));
}

// "3 more, 0.1 to 0.4 points each: --all-findings lists them". Points are the largest decrease of a
// joint's held-out error.
std::string small_findings_line(const Diagnosis& d, size_t count) {
  double least = numerics::kHuge, most = 0.0;
  for (const Finding& f : d.findings) {
    if (f.main || f.test_before.size() == 0 || f.test_after.size() != f.test_before.size()) continue;
    const double points = std::max(0.0, kPercent * (f.test_before - f.test_after).maxCoeff());
    least = std::min(least, points);
    most = std::max(most, points);
  }
  return fmt::format("{} more{}: --all-findings lists {}\n", count,
                     most > 0.0 ? fmt::format(", {:.1f} to {:.1f} points of a joint's error{}", std::min(least, most), most, count == 1 ? "" : " each") : "",
                     count == 1 ? "it" : "them");
}

// Splits a joint's error into noise floor and removable part, 12.3 % = 4.1 % floor + 8.2 %, with the share of
// the latter that the findings explain.
std::string joint_text(const Diagnosis& d, const JointVerdict& v) {
  const auto& joints = d.baseline.model->coordinates();
  if (!std::isfinite(v.held_out))
    return fmt::format("  joint {} ({}): {}: {}\n", v.joint.value + 1, joints[v.joint.value].name, state_words(v), v.why);
  std::string out =
      fmt::format("  joint {} ({}): {:.2f} = {:.2f} {} + {:.2f}: {}", v.joint.value + 1,
                  joints[v.joint.value].name, kPercent * v.held_out,
                  kPercent * v.floor,
                  v.source == FloorSource::kRepeats ? "between repeats" : "that nothing predicts",
                  kPercent * v.removable, state_words(v));
  if (v.state != JointState::kAtFloor) {
    out += fmt::format(" ({:.2f} with names, {:.2f} without, {:.2f} left)",
                       kPercent * (v.held_out - v.extended), kPercent * (v.extended - v.left),
                       kPercent * (v.left - v.floor));
  }
  return out + (v.why.empty() ? "\n" : ": " + v.why + "\n");
}

std::string summary_text(const Diagnosis& d) {
  const DiagnosisSummary& s = d.summary;
  const size_t all = d.findings.size();
  std::string out;
  if (all > 1 && static_cast<size_t>(s.main) < all) {
    out += fmt::format(
        "\nthe first {} of {} findings explain {:.0f} % of the removable held-out error, all of them "
        "{:.0f} %\n",
        s.main, all, kPercent * s.explained_by_main, kPercent * s.explained_by_all);
  }
  return out;
}

std::string worsening_text(const Diagnosis& d, JointIndex joint) {
  const int i = joint.value;
  const std::string name =
      d.baseline.model ? d.baseline.model->coordinates()[i].name : "";
  return fmt::format("the extended model is worse on joint {} ({}): {:.1f} -> {:.1f} % held out",
                     i + 1, name, kPercent * d.baseline.test_error.relative[i],
                     kPercent * d.extended.test_error.relative[i]);
}

// Table of the friction that was added to the arm: one line for each joint.
std::string friction_table(const Diagnosis& d) {
  std::string out = "\nfriction, offset and rotor inertia that were found, +- standard deviation\n";
  std::optional<JointIndex> joint;
  for (const JointNumber& n : d.friction) {
    if (n.joint != joint)
      out += fmt::format("{}  {:<22}", joint ? "\n" : "",
                         d.extended.model->coordinates()[n.joint.value].name);
    joint = n.joint;
    const std::string spread =
        std::isfinite(n.deviation) ? fmt::format(" +- {:.1g}", n.deviation) : std::string();
    out += fmt::format(" {} {:.4g}{} {};", n.effect, n.value, spread, n.unit);
  }
  return out + "\n";
}

}  // namespace

std::string Diagnosis::sentence(const Finding& finding) const {
  return baseline.model ? veridyn::sentence(*baseline.model, finding) : finding.phrase;
}

std::string NextExperiment::words(const Model& arm, size_t k) const {
  const CauseWords w = words_of(arm, between[k]);
  if (!w.frame.empty()) return w.effect + " on " + w.frame;
  return w.joint ? w.effect + " on joint " + std::to_string(w.joint->value + 1) : w.effect;
}

const char* name_of(JointState state) {
  switch (state) {
    case JointState::kAtFloor: return "at_floor";
    case JointState::kNamed: return "named";
    case JointState::kUnnamed: return "unnamed";
    case JointState::kCannotTell: return "cannot_tell";
  }
  return "";
}

const char* name_of(FloorSource source) {
  return source == FloorSource::kRepeats ? "repeats" : "regression";
}

bool Diagnosis::has_answer() const {
  return !findings.empty() || hypotheses > 0 || joints.empty() ||
         std::any_of(joints.begin(), joints.end(), [](const JointVerdict& v) { return v.state != JointState::kCannotTell || !std::isfinite(v.held_out); });
}

std::string mistakes_text(const Diagnosis& d) {
  std::string wrong;
  std::set<std::pair<QualityKind, std::optional<JointIndex>>> once;  // recordings with the same mistake differ in its numbers
  for (const RecordingQuality& q : d.data_quality) {
    for (const QualityFinding& f : q.findings) {
      if (is_contradiction(f) && once.insert({f.kind, f.joint}).second) wrong += f.sentence + " ";
    }
  }
  return wrong.empty() ? wrong : wrong + (d.mended ? "With that: " : "As recorded: ");
}

std::string Diagnosis::verdict() const {
  const std::string wrong = mistakes_text(*this);  // these come first
  if (!has_answer()) return wrong + "cannot tell: " + joints.front().why;
  const auto is_cut = [this](JointIndex joint) {
    return std::any_of(data_quality.begin(), data_quality.end(), [&](const RecordingQuality& q) {
      return std::any_of(q.saturated.begin(), q.saturated.end(), [&](const SaturatedInterval& one) { return one.joint == joint; });
    });
  };
  if (findings.empty()) {
    std::string left, unknown, cut, still, loud;
    for (const JointVerdict& v : joints) {
      if (v.state == JointState::kAtFloor) {
        if (v.held_out > identifying::kLoud) loud += fmt::format("{}{} ({:.2g} %)", loud.empty() ? "" : ", ", v.joint.value + 1, numerics::kPercent * v.held_out);
        continue;
      }
      const std::string& name = baseline.model->coordinates()[v.joint.value].name;
      const bool is_still = std::find(baseline.still_in_test.begin(), baseline.still_in_test.end(), name) != baseline.still_in_test.end();
      std::string& list = !std::isfinite(v.held_out) ? unknown : is_still ? still : left;
      list += (list.empty() ? "" : ", ") + std::to_string(v.joint.value + 1);
      if (is_cut(v.joint)) cut += (cut.empty() ? "" : ", ") + std::to_string(v.joint.value + 1);
    }
    const std::string apart = changes ? recordings_apart(baseline) : "";
    const std::string nothing = !apart.empty() ? "nothing has changed in the held-out recordings" : changes ? "nothing has changed" : wrong.empty() ? "none" : "no further cause";
    const std::string but = apart.empty() ? "" : ", but " + apart;
    if (left.empty() && unknown.empty() && still.empty() && loud.empty()) return wrong + nothing + but;
    return wrong + "no cause was found" + (left.empty() ? "" : "; joints above their floor: " + left) +
           (loud.empty() ? "" : "; joints with an error that no signal of the recordings predicts: " + loud + ", noise or something that does not follow the motion") +
           (cut.empty() ? "" : "; joints whose recorded torque stands at a limit: " + cut + ", record motions that need less") +
           (still.empty() ? "" : "; joints that hardly move in the held-out recordings: " + still + ", test on a motion") +
           (unknown.empty() ? "" : "; joints without a held-out error: " + unknown) + but;
  }
  std::string out = wrong + sentence(findings.front());
  if (findings.front().status == FindingStatus::kNotConfirmed)
    out += " The training recordings do not confirm it.";
  if (findings.front().held_out() == Agreement::kContradicts)
    out += " The held-out recordings are predicted no better with it.";
  std::string same;
  for (const Rival& r : findings.front().rivals) {
    if (r.share >= numerics::kWhole) same += (same.empty() ? "" : ", or from ") + rival_text(*this, r);
  }
  if (!same.empty()) out += " The recordings cannot tell it from " + same + ".";
  if (findings.front().shape && findings.front().joint && is_cut(*findings.front().joint))
    out += " Its recorded torque stands at a limit, which alone makes such a curve: record motions that need less.";
  const auto largest = std::max_element(findings.begin(), findings.end(), [](const Finding& a, const Finding& b) {
    return a.explains < b.explains;
  });
  if (!findings.front().shape && largest->shape)
    out += fmt::format(" More of the error, {}, has no name: {}", share_text(largest->explains), sentence(*largest));
  for (const JointIndex joint : summary.worse_joints) {
    std::string words = worsening_text(*this, joint);
    words.front() = 'T';
    out += " " + words + ".";
  }
  if (changes) {
    if (const std::string apart = recordings_apart(baseline); !apart.empty()) out += " But " + apart + ".";
  }
  return out;
}

std::string Diagnosis::report(const std::string& next_command) const {
  if (!baseline.model) return baseline.report();
  std::string out = fmt::format("verdict: {}\n{}: {} hypotheses tested in {:.1f} s\n", verdict(),
                                baseline.robot, hypotheses, seconds);
  for (const std::string& warning : baseline.warnings) out += "warning: " + warning + "\n";
  for (const RecordingQuality& q : data_quality) {
    for (const QualityFinding& f : q.findings) {
      if (f.severity != Severity::kInfo)
        out += fmt::format("recording {}: {}\n", q.file, f.sentence);
    }
  }
  for (const auto* list : {&baseline.train, &baseline.test}) {
    for (const RecordingError& r : *list) {
      if (r.filled.count > r.rows / 1000)  // fewer rows are not mentioned
        out += fmt::format("recording {}: {}\n", r.source, filled_text(r.filled, r.rows));
    }
  }
  if (!friction_remark.empty()) out += friction_remark + " Found: table below.\n";
  if (provisional) out += "one recording to learn from: names are provisional\n";
  for (const std::vector<JointIndex>& group : moving_as_one) {
    if (!has_answer()) break;  // the verdict states the reason
    out += "joints " + numbers_from_one(group) +
           " move as one in all training recordings: what depends on one of them cannot be told from "
           "the others\n";
  }
  if (!findings.empty())
    out += changes ? "\nwhat changed since the model was made:\n" : "\nwhat the model lacks:\n";
  for (const Finding& f : findings) {
    if (f.main) out += finding_text(*this, f);
  }
  const size_t small = findings.size() - static_cast<size_t>(summary.main);
  if (small > 0 && small_apart) {
    out += small_findings_line(*this, small);
  } else if (small > 0) {
    out += "more";
    if (errors_jump(*this))
      out += ", which came between those above: the error before one of these is then not that after the last";
    out += ":\n";
  }
  for (const Finding& f : findings) {
    if (!f.main && !small_apart) out += small_finding_text(*this, f);
  }
  for (const std::string& remark : remarks) out += "remark: " + remark + "\n";
  out += summary_text(*this);
  for (const JointIndex joint : summary.worse_joints) out += "WARNING: " + worsening_text(*this, joint) + "\n";
  out += "\nerrors, % of the torque, per joint; held out: every row as recorded\n";
  if (baseline.weights == JointWeights::kResidual)
    out += "  joints weighted by their residual: the baseline is that of `identify --weights residual`\n";
  const size_t width = table_width(*baseline.model);
  out += fmt::format("  {:<24}", "");
  for (const Coordinate& c : baseline.model->coordinates())
    out += fmt::format("{:>{}}", c.name, width);
  out += "\n";
  const auto line = [&](const char* name, const VectorXd& v) {
    if (v.size() == 0) return;
    out += fmt::format("  {:<24}", name);
    for (Eigen::Index i = 0; i < v.size(); ++i)
      out += in_percent(v[i], width);
    out += "\n";
  };
  line("held out, baseline", baseline.test_error.relative);
  line("held out, extended", extended.test_error.relative);
  line("  late rows repaired", extended.test_repaired.relative);
  line("  without excluded rows", extended.test_without_excluded.relative);
  line("training, baseline", baseline.train_error.relative);
  line("training, extended", extended.train_error.relative);
  line(noise_floor_label(baseline), baseline.noise_floor);
  if (has_answer()) out += "\nwhat the held-out error of each joint is made of, % of its torque\n";
  for (const JointVerdict& v : joints) out += has_answer() ? joint_text(*this, v) : "";
  if (!friction.empty()) out += friction_table(*this);
  if (!next_experiment.between.empty()) {
    out += fmt::format("next experiment, to separate {} from {}",
                       next_experiment.words(*baseline.model, 0),
                       next_experiment.words(*baseline.model, 1));
    out += next_command.empty() ? "\n" : ":\n  " + next_command + "\n";
  }
  if (!next_experiment.shows.empty()) {
    out += "next experiment, to show " + next_experiment.shows;
    out += next_command.empty() ? "\n" : ":\n  " + next_command + "\n";
  }
  // Effects that were found in several places share one line.
  for (size_t k = 0; k < cannot_tell.size();) {
    const CannotTell& first = cannot_tell[k];
    std::vector<std::string> places;
    for (; k < cannot_tell.size() && cannot_tell[k].effect == first.effect && cannot_tell[k].why == first.why; ++k) {
      const std::string place = cannot_tell[k].cause ? place_of_joint(words_of(*baseline.model, *cannot_tell[k].cause)) : "";
      if (std::find(places.begin(), places.end(), place) == places.end()) places.push_back(place);
    }
    out += fmt::format("cannot tell: {}{}: {}\n", first.effect, fmt::join(places, ","), first.why);
  }
  return out;
}

}  // namespace veridyn
