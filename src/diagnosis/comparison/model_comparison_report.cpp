#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "diagnosis/comparison/comparison_numbers.hpp"
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
