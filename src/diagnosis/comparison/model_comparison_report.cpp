#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "diagnosis/comparison/comparison_numbers.hpp"
#include "math/digits.hpp"
#include "veridyn/diagnosis/model_comparison.hpp"
#include "model/suggestion.hpp"

namespace veridyn {
namespace {

std::string model_line(const char* which, const ComparedModel& m) {
  std::string out = fmt::format("{:<7} {}", which, m.name);
  if (!m.recordings.empty()) out += ", from " + listed(m.recordings);
  if (m.clusters > 0) {
    out += fmt::format(", {} clusters", m.clusters);
  } else {
    out += ", no statistics: taken as exact";
  }
  if (m.training_error.size() > 0) {
    out += ", training errors, %:";
    for (const double e : m.training_error) out += fmt::format(" {:.1f}", 100.0 * e);
  }
  if (!m.note.empty()) out += "; " + m.note;
  return out + "\n";
}

// A model that leaves much more of its own recordings than the other: its numbers may be biased.
std::string worse_fit_text(const std::vector<TorqueDifference>& joints, const char* which, const ComparedModel& one, const char* than, const ComparedModel& other) {
  std::vector<std::string> worse;
  for (Eigen::Index i = 0; i < std::min(one.training_error.size(), other.training_error.size()); ++i) {
    if (one.training_error[i] > comparing::numbers.fits_worse * other.training_error[i])
      worse.push_back(fmt::format("{} ({} % of the torque against {} %)", joints[static_cast<std::size_t>(i)].coordinate,
                                  in_percent(one.training_error[i]), in_percent(other.training_error[i])));
  }
  if (worse.empty()) return "";
  return fmt::format("The model {} fits its own recordings worse than the model {} fits its own, on {}: differences may be what it lacks.\n",
                     which, than, listed(worse));
}

// One factor between the torques of all joints: a unit or a gain, not a change of every body.
std::string factor_text(const std::vector<TorqueDifference>& joints) {
  const auto product = [](const TorqueDifference& j) { return 0.5 * (j.before * j.before + j.after * j.after - j.difference * j.difference); };
  double factor = 0.0;
  for (const TorqueDifference& j : joints) factor += product(j) / (j.before * j.before) / static_cast<double>(joints.size());
  const bool all = joints.size() > 1 && std::all_of(joints.begin(), joints.end(), [&](const TorqueDifference& j) {
    const double left = j.after * j.after - factor * (2.0 * product(j) - factor * j.before * j.before);
    const double unseen = std::max(2.0 * j.by_chance, comparing::numbers.rounded_away * j.after);
    return j.difference > unseen && left <= unseen * unseen;
  });
  return all ? fmt::format("The torques of all joints after are {:.4g} times those before, and otherwise differ by no more than chance or {:.2g} %: another unit or gain of the torques?\n",
                           factor, 100.0 * comparing::numbers.rounded_away) : "";
}

std::string verdict_text(const ModelComparison& c) {
  if (c.verdict == ComparisonVerdict::kCannotTell)
    return "verdict: cannot tell; neither file carries the statistics of its identification";
  if (c.verdict == ComparisonVerdict::kSame) {
    return fmt::format(
        "verdict: no difference beyond chance in {} numbers ({:.3g} % for all of "
        "them together, Holm)",
        c.compared(), 100.0 * c.significance);
  }
  return fmt::format("verdict: {} of {} numbers differ ({:.3g} % for all of them together, Holm)",
                     c.significant(), c.compared(), 100.0 * c.significance);
}

// Most significant first; the rest of a long list is counted.
std::string list_text(const char* title, const std::vector<ModelDifference>& all) {
  std::vector<ModelDifference> told;
  for (const ModelDifference& d : all) {
    if (d.significant && d.same_as.empty()) told.push_back(d);
  }
  std::stable_sort(told.begin(), told.end(), [](const ModelDifference& a, const ModelDifference& b) {
    return std::abs(a.t) > std::abs(b.t);
  });
  std::string out;
  for (const ModelDifference& d : told) {
    if (&d - told.data() == comparing::kListed) break;
    out += fmt::format(
        "  {}\n     t = {:.1f} with {:.1f} degrees of freedom, p = {:.1e}, "
        "corrected {:.1e}\n",
        d.sentence, d.t, d.degrees_of_freedom, d.p_value, d.p_corrected);
  }
  if (told.size() > static_cast<std::size_t>(comparing::kListed))
    out += fmt::format("  and {} more, less sure; --json has all.\n",
                       told.size() - static_cast<std::size_t>(comparing::kListed));
  return out.empty() ? out : std::string("\n") + title + "\n" + out;
}

std::string torque_table(const std::vector<TorqueDifference>& joints) {
  std::string out =
      "\ntorque over the standard motion, rms\n"
      "  joint                        before      after difference   share  by chance     bodies   "
      " "
      "effects\n";
  for (const TorqueDifference& j : joints) {
    out += fmt::format(
        "  {:<16} {:<5} {:12.4g} {:10.4g} {:10.4g} {:6.1f} % {:10} {:10.3g} {:10.3g}\n",
        j.coordinate, j.unit, j.before, j.after, j.difference, 100.0 * j.share,
        std::isfinite(j.by_chance) ? fmt::format("{:.3g}", j.by_chance) : "-", j.bodies, j.effects);
  }
  return out;
}

}  // namespace

std::string ModelComparison::report() const {
  std::string out = model_line("before", before) + model_line("after", after);
  if (same_motion) out += "the same motion: compared cluster by cluster\n";
  out += worse_fit_text(torque, "before", before, "after", after) + worse_fit_text(torque, "after", after, "before", before);
  out += factor_text(torque);
  if (!structure.empty()) out += "\nnot built alike:\n";
  for (const StructureDifference& s : structure) out += "  " + s.sentence + "\n";
  if (!only_before.empty() || !only_after.empty()) {
    out += fmt::format(
        "  {} base parameters are determined before only, {} after only: not compared.\n",
        only_before.size(), only_after.size());
  }
  out += "\n" + verdict_text(*this) + "\n";
  out += list_text("what the joints feel:", joints);
  out += list_text("parameters:", parameters);
  if (significant() > 0) {
    out +=
        "\nSizes are those of least squares without conditions, to which the statistics belong; "
        "where a model was\nheld to what is physically possible, its own values differ from "
        "them.\n";
  }
  return out + torque_table(torque);
}

}  // namespace veridyn
